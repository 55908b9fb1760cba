/* lockstep: preloaded into an unmodified Betaflight SITL, it stops the firmware's clock between two orders.
 *
 * The firmware believes that it has a clock, three threads and the network. Here its clock is a counter, its threads are coroutines
 * on one thread, and its packets come and go over one descriptor, so what it computes depends on its orders alone: flights repeat bit
 * for bit, several run side by side, nothing listens on any port, and an armed firmware can be copied with fork().
 *
 *   LOCKSTEP_ORDERS   descriptor (SOCK_SEQPACKET) that orders come from and replies go to; when its other end closes, the process ends
 *   LOCKSTEP_CONSOLE  descriptor (SOCK_STREAM) that takes the place of the first serial port; time then runs freely
 *   LOCKSTEP_BOOT     nanoseconds that the firmware may run before its first order
 *   LOCKSTEP_PAUSE    nanoseconds that pass between two looks of its scheduler
 *
 * No line of this file is the firmware's. Licence: MIT.
 */
#define _GNU_SOURCE
#include <dlfcn.h>
#include <errno.h>
#include <netinet/in.h>
#include <poll.h>
#include <pthread.h>
#include <signal.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>
#include <sys/select.h>
#include <sys/socket.h>
#include <sys/time.h>
#include <time.h>
#include <ucontext.h>
#include <unistd.h>

enum { STATE_PORT = 9003, STICKS_PORT = 9004, MOTORS_PORT = 9002, CONSOLE_PORT = 5761 };
enum { THREADS = 8, STACK = 1 << 20, SCHEDULER_PAUSE = 50000, CLOCK_LOOK = 200, LOOKS_A_CONSOLE = 16, BILLION = 1000000000 };
enum { RUN = 1, COPY = 2, READY = 3 };

struct order { /* what `link.py` sends */
    uint64_t kind, until;
    struct { double time; uint16_t channels[16]; } sticks;
    double state[18];
};

struct reply { /* and what it gets */
    uint64_t kind, now, process, updates;
    float motors[4];
};

struct thread { /* of the firmware, as a coroutine */
    ucontext_t context;
    void *(*start)(void *);
    void *argument;
    int waits_for; /* descriptor of its packets, -1: it serves the console */
};

static int (*real_bind)(int, const struct sockaddr *, socklen_t);
static int (*real_accept)(int, struct sockaddr *, socklen_t *);
static int (*real_listen)(int, int);
static int (*real_select)(int, fd_set *, fd_set *, fd_set *, struct timeval *);
static int (*real_create)(pthread_t *, const pthread_attr_t *, void *(*)(void *), void *);

static struct thread threads[THREADS];
static ucontext_t scheduler;
static int running = -1, thread_count;
static int orders = -1, console = -1, server = -1, nothing = -1, state_packets = -1, stick_packets = -1;
static uint64_t now = 1000000, granted, pause_length;
static unsigned looks;
static const void *packet;
static size_t packet_size;
static struct reply reply = { .kind = READY };

static uint64_t setting(const char *name, uint64_t otherwise)
{
    const char *text = getenv(name);
    return text ? strtoull(text, NULL, 10) : otherwise;
}

/* A thread of the machine, not of the firmware: ends the process when nobody is there any more to give orders. */
static void *watch(void *unused)
{
    struct pollfd end = { .fd = orders };
    while (poll(&end, 1, -1) < 0 || !(end.revents & (POLLHUP | POLLERR | POLLNVAL))) {}
    _exit(0);
    return unused;
}

static void begin_to_watch(void)
{
    pthread_t watcher;
    sigset_t all, before;
    sigfillset(&all);
    pthread_sigmask(SIG_SETMASK, &all, &before);
    if (real_create(&watcher, NULL, watch, NULL)) _exit(3);
    pthread_sigmask(SIG_SETMASK, &before, NULL);
}

__attribute__((constructor)) static void begin(void)
{
    real_bind = dlsym(RTLD_NEXT, "bind");
    real_accept = dlsym(RTLD_NEXT, "accept");
    real_listen = dlsym(RTLD_NEXT, "listen");
    real_select = dlsym(RTLD_NEXT, "select");
    real_create = dlsym(RTLD_NEXT, "pthread_create");
    orders = (int)setting("LOCKSTEP_ORDERS", -1);
    console = (int)setting("LOCKSTEP_CONSOLE", -1);
    granted = console >= 0 ? UINT64_MAX : setting("LOCKSTEP_BOOT", BILLION);
    pause_length = setting("LOCKSTEP_PAUSE", 10000);
    unsetenv("LD_PRELOAD");
    if (orders < 0) return; /* a program that the firmware starts, or nobody's */
    signal(SIGCHLD, SIG_IGN);
    begin_to_watch();
}

/* Coroutines */

static void resume(int k)
{
    running = k;
    swapcontext(&scheduler, &threads[k].context);
    running = -1;
}

static void give_way(void)
{
    const int k = running;
    swapcontext(&threads[k].context, &scheduler);
}

static void enter(int k)
{
    threads[k].start(threads[k].argument);
    for (;;) give_way();
}

int pthread_create(pthread_t *thread, const pthread_attr_t *attributes, void *(*start)(void *), void *argument)
{
    if (orders < 0) return real_create(thread, attributes, start, argument);
    if (thread_count == THREADS) return EAGAIN;
    const int k = thread_count++;
    struct thread *t = &threads[k];
    void *stack = mmap(NULL, STACK, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
    if (stack == MAP_FAILED || getcontext(&t->context)) return EAGAIN;
    t->context.uc_stack.ss_sp = stack;
    t->context.uc_stack.ss_size = STACK;
    t->start = start;
    t->argument = argument;
    t->waits_for = -1;
    makecontext(&t->context, (void (*)(void))enter, 1, k);
    *thread = (pthread_t)k;
    resume(k);
    return 0;
}

int pthread_join(pthread_t thread, void **result)
{
    (void)thread, (void)result;
    return 0; /* it has no thread to wait for */
}

static void deliver(int descriptor, const void *data, size_t size)
{
    packet = data;
    packet_size = size;
    for (int k = 0; k < thread_count; k++)
        if (descriptor >= 0 && threads[k].waits_for == descriptor) resume(k);
    packet = NULL;
}

/* Orders */

static int receive(struct order *order)
{
    int handed = -1;
    char space[CMSG_SPACE(sizeof(int))];
    struct iovec part = { order, sizeof *order };
    struct msghdr message = { .msg_iov = &part, .msg_iovlen = 1, .msg_control = space, .msg_controllen = sizeof space };
    ssize_t size;
    do size = recvmsg(orders, &message, MSG_CMSG_CLOEXEC);
    while (size < 0 && errno == EINTR);
    if (size != sizeof *order) _exit(size == 0 ? 0 : 4);
    struct cmsghdr *extra = CMSG_FIRSTHDR(&message);
    if (extra && extra->cmsg_type == SCM_RIGHTS) memcpy(&handed, CMSG_DATA(extra), sizeof handed);
    return handed;
}

static void answer(void)
{
    reply.now = now;
    reply.process = (uint64_t)getpid();
    if (send(orders, &reply, sizeof reply, MSG_NOSIGNAL) != sizeof reply) _exit(0);
    reply.updates = 0;
}

static void obey(void)
{
    struct order order;
    answer();
    for (;;) {
        const int handed = receive(&order);
        if (order.kind == RUN && order.until > granted) break;
        if (order.kind != COPY || handed < 0) _exit(4);
        const pid_t child = fork();
        if (child == 0) {
            close(orders);
            orders = handed;
            begin_to_watch();
            answer();
        } else close(handed);
    }
    deliver(stick_packets, &order.sticks, sizeof order.sticks);
    deliver(state_packets, order.state, sizeof order.state);
    granted = order.until;
}

/* What the firmware calls */

int nanosleep(const struct timespec *asked, struct timespec *left)
{
    (void)left;
    const uint64_t length = (uint64_t)asked->tv_sec * BILLION + (uint64_t)asked->tv_nsec;
    now += length == SCHEDULER_PAUSE ? pause_length : length;
    if (console >= 0 && ++looks % LOOKS_A_CONSOLE == 0)
        for (int k = 0; k < thread_count; k++)
            if (threads[k].waits_for < 0) resume(k);
    if (now >= granted) obey();
    return 0;
}

int clock_gettime(clockid_t clock, struct timespec *time)
{
    (void)clock;
    if (running < 0) now += CLOCK_LOOK; /* else loops that wait for a time would never end */
    time->tv_sec = (time_t)(now / BILLION);
    time->tv_nsec = (long)(now % BILLION);
    return 0;
}

int gettimeofday(struct timeval *time, void *zone)
{
    (void)zone;
    time->tv_sec = (time_t)(now / BILLION);
    time->tv_usec = (suseconds_t)(now % BILLION / 1000);
    return 0;
}

int bind(int descriptor, const struct sockaddr *address, socklen_t size)
{
    int kind = 0;
    socklen_t length = sizeof kind;
    if (orders < 0) return real_bind(descriptor, address, size);
    getsockopt(descriptor, SOL_SOCKET, SO_TYPE, &kind, &length);
    const int port = ntohs(((const struct sockaddr_in *)address)->sin_port); /* where IPv6 has it, too */
    if (kind == SOCK_DGRAM && port == STATE_PORT) state_packets = descriptor;
    if (kind == SOCK_DGRAM && port == STICKS_PORT) stick_packets = descriptor;
    if (kind == SOCK_DGRAM) return 0;
    if (console >= 0 && port == CONSOLE_PORT) {
        server = descriptor;
        return dup2(console, server) < 0 ? -1 : 0;
    }
    errno = EACCES;
    return -1;
}

int listen(int descriptor, int backlog)
{
    return orders >= 0 && descriptor == server ? 0 : real_listen(descriptor, backlog);
}

int accept(int descriptor, struct sockaddr *address, socklen_t *size)
{
    if (orders < 0) return real_accept(descriptor, address, size);
    if (descriptor != server || nothing >= 0) {
        errno = EWOULDBLOCK;
        return -1;
    }
    int ends[2];
    const int client = dup(server);
    if (client < 0 || pipe(ends)) return -1;
    nothing = ends[0]; /* nobody writes to it: no other client comes */
    dup2(nothing, server);
    return client;
}

int select(int count, fd_set *read, fd_set *write, fd_set *except, struct timeval *timeout)
{
    if (running < 0) return real_select(count, read, write, except, timeout);
    struct thread *t = &threads[running];
    if (read && state_packets >= 0 && FD_ISSET(state_packets, read)) t->waits_for = state_packets;
    else if (read && stick_packets >= 0 && FD_ISSET(stick_packets, read)) t->waits_for = stick_packets;
    give_way();
    if (t->waits_for >= 0) return 1;
    struct timeval none = { 0, 0 };
    return real_select(count, read, write, except, &none);
}

ssize_t recvfrom(int descriptor, void *data, size_t size, int flags, struct sockaddr *address, socklen_t *length)
{
    (void)descriptor, (void)flags, (void)address, (void)length;
    const size_t taken = size < packet_size ? size : packet_size;
    memcpy(data, packet, taken);
    return (ssize_t)taken;
}

ssize_t sendto(int descriptor, const void *data, size_t size, int flags, const struct sockaddr *address, socklen_t length)
{
    (void)descriptor, (void)flags, (void)length;
    if (address && ntohs(((const struct sockaddr_in *)address)->sin_port) == MOTORS_PORT && size == sizeof reply.motors) {
        memcpy(reply.motors, data, size);
        reply.updates++;
    }
    return (ssize_t)size;
}
