/** Signal: a value that calls its watchers when it changes. */
export class Signal<T> {
  private readonly watchers = new Set<(value: T) => void>();

  constructor(private current: T) {}

  get value(): T {
    return this.current;
  }

  set value(value: T) {
    if (Object.is(value, this.current)) return;
    this.current = value;
    for (const watch of this.watchers) watch(value);
  }

  /** Calls now and after each change. */
  watch(call: (value: T) => void): void {
    call(this.current);
    this.after(call);
  }

  /** Calls after each change. */
  after(call: (value: T) => void): void {
    this.watchers.add(call);
  }
}
