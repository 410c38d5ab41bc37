/*
 * What lies between the kernel as a process and the kernel below. Preloaded, it changes two things.
 *
 * Registers. The machine saves the registers of its processes by ptrace, 2696 bytes of them: what a
 * processor has up to AVX-512 and protection keys. The kernel below refuses to set anything but the
 * whole state, which is longer where the processor has more (AMX: 11008 bytes), and the machine would
 * end at its first process. Here the whole state is set: what the machine knows, and the rest as it is.
 *
 * Time. It passes while the machine has nothing to do: then it jumps to where the next timer is due. While
 * it works, time hardly passes: a twentieth of the time outside, and never much at once. So a bus in real
 * time works on a computer of any speed, whatever else that does; and how long something took in there
 * says nothing. (Until its first process runs, time is as outside: the kernel measures how fast it is
 * while it starts.) The machine has one timer, and asks what is left of it only when it has nothing to do.
 */
#define _GNU_SOURCE
#include <dlfcn.h>
#include <elf.h>
#include <errno.h>
#include <stdarg.h>
#include <stdlib.h>
#include <string.h>
#include <sys/ptrace.h>
#include <sys/syscall.h>
#include <sys/uio.h>
#include <time.h>
#include <unistd.h>

#define SECOND 1000000000LL

/* Of the time outside, one part in so many passes while the machine works; and at most so much at once. */
#define BUSY 20
#define AT_ONCE 50000LL

static int slowness = 1;

/* More than any processor has. */
static __thread char whole_state[65536];

static long extended_state(enum __ptrace_request request, int process, struct iovec *known)
{
    struct iovec whole = { whole_state, sizeof whole_state };
    size_t length;

    if (syscall(SYS_ptrace, PTRACE_GETREGSET, process, NT_X86_XSTATE, &whole) < 0)
        return -1;
    length = known->iov_len < whole.iov_len ? known->iov_len : whole.iov_len;
    if (request == PTRACE_GETREGSET) {
        memcpy(known->iov_base, whole_state, length);
        known->iov_len = length;
        return 0;
    }
    slowness = BUSY;
    memcpy(whole_state, known->iov_base, length);
    return syscall(SYS_ptrace, PTRACE_SETREGSET, process, NT_X86_XSTATE, &whole);
}

long ptrace(enum __ptrace_request request, ...)
{
    va_list arguments;
    void *address, *data;
    int process;

    va_start(arguments, request);
    process = va_arg(arguments, int);
    address = va_arg(arguments, void *);
    data = va_arg(arguments, void *);
    va_end(arguments);

    if ((request == PTRACE_GETREGSET || request == PTRACE_SETREGSET) && (long)address == NT_X86_XSTATE)
        return extended_state(request, process, data);
    if (request == PTRACE_PEEKTEXT || request == PTRACE_PEEKDATA || request == PTRACE_PEEKUSER) {
        long word;
        /* the C library's function returns the word, the system call stores it */
        if (syscall(SYS_ptrace, request, process, address, &word) < 0)
            return -1;
        errno = 0;
        return word;
    }
    return syscall(SYS_ptrace, request, process, address, data);
}

/* The machine's time, ns; the time outside when it was last looked at; when the timer is due, 0: never. */
static long long inside, outside, due, period;
static timer_t timer_below;

static long long nanoseconds(const struct timespec *time)
{
    return time->tv_sec * SECOND + time->tv_nsec;
}

static struct timespec timespec(long long nanoseconds)
{
    struct timespec time = { nanoseconds / SECOND, nanoseconds % SECOND };
    return time;
}

static long long look(void)
{
    struct timespec time;
    long long now, passed;

    syscall(SYS_clock_gettime, CLOCK_MONOTONIC, &time);
    now = nanoseconds(&time);
    if (outside == 0)
        inside = outside = now;
    passed = (now - outside) / slowness;
    inside += slowness == 1 || passed < AT_ONCE ? passed : AT_ONCE;
    outside = now;
    return inside;
}

int clock_gettime(clockid_t clock, struct timespec *time)
{
    static long long ahead;
    struct timespec real;

    if (clock == CLOCK_MONOTONIC) {
        *time = timespec(look());
        return 0;
    }
    if (clock != CLOCK_REALTIME)
        return syscall(SYS_clock_gettime, clock, time);
    if (ahead == 0) {
        syscall(SYS_clock_gettime, clock, &real);
        ahead = nanoseconds(&real) - look();
    }
    *time = timespec(ahead + look());
    return 0;
}

static int set_below(long long first, long long then)
{
    static int (*below)(timer_t, int, const struct itimerspec *, struct itimerspec *);
    struct itimerspec set = { timespec(then), timespec(first) };

    if (!below)
        below = dlsym(RTLD_NEXT, "timer_settime");
    return below(timer_below, 0, &set, NULL);
}

/* The machine's times are relative. */
int timer_settime(timer_t timer, int flags, const struct itimerspec *set, struct itimerspec *old)
{
    long long first = nanoseconds(&set->it_value);

    (void)flags;
    (void)old;
    timer_below = timer;
    due = first ? look() + first : 0;
    period = nanoseconds(&set->it_interval);
    return set_below(first * slowness, period * slowness);
}

/* Asked when there is nothing to do: time jumps, and the timer fires at once. */
int timer_gettime(timer_t timer, struct itimerspec *left)
{
    (void)timer;
    left->it_interval = timespec(period);
    left->it_value = timespec(due ? 1 : 0);
    if (due == 0)
        return 0;
    if (look() < due)
        inside = due;
    due = period ? due + period : 0;
    return set_below(1, period * slowness);
}
