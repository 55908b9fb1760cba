/** Signal: a value that tells when it changes. */
export class Signal<T> {
  private readonly watchers = new Set<(value: T) => void>();

  constructor(private held: T) {}

  get value(): T {
    return this.held;
  }

  set value(value: T) {
    if (Object.is(value, this.held)) return;
    this.held = value;
    for (const watch of this.watchers) watch(value);
  }

  /** Calls now and after each change. */
  watch(call: (value: T) => void): void {
    call(this.held);
    this.after(call);
  }

  /** Calls after each change. */
  after(call: (value: T) => void): void {
    this.watchers.add(call);
  }
}
