/* The run phase makes no system call: in a child process a seccomp filter leaves exit_group alone;
 * any other call ends the child, and says which it was. Reading the clock, which needs no call
 * where the kernel maps it, is caught by tests/restraint. */
#define _GNU_SOURCE /* for syscall */
#include "run_load.h"

#include <errno.h>
#include <linux/filter.h>
#include <linux/seccomp.h>
#include <signal.h>
#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>
#include <sys/mman.h>
#include <sys/prctl.h>
#include <sys/syscall.h>
#include <sys/wait.h>
#include <unistd.h>

#define STEPS_PER_LOAD 20 /* of each kind */
#define EXIT_CAUGHT    99
#define EXIT_NO_FILTER 98

/* What a child tells: it may not write. */
typedef struct report {
    int call, load, steps, errors, filter_errno;
} report;

static volatile report *told;

static void caught(int number, siginfo_t *info, void *context) {
    (void)number, (void)context;
    told->call = info->si_syscall;
    _exit(EXIT_CAUGHT);
}

static void close_the_door(void) {
    struct sock_filter rules[] = {
        BPF_STMT(BPF_LD | BPF_W | BPF_ABS, offsetof(struct seccomp_data, nr)),
        BPF_JUMP(BPF_JMP | BPF_JEQ | BPF_K, SYS_exit_group, 0, 1),
        BPF_STMT(BPF_RET | BPF_K, SECCOMP_RET_ALLOW),
        BPF_STMT(BPF_RET | BPF_K, SECCOMP_RET_TRAP),
    };
    struct sock_fprog program = {sizeof rules / sizeof *rules, rules};
    struct sigaction action = {.sa_sigaction = caught, .sa_flags = SA_SIGINFO};
    sigaction(SIGSYS, &action, NULL);
    if (prctl(PR_SET_NO_NEW_PRIVS, 1, 0, 0, 0) == 0 &&
        prctl(PR_SET_SECCOMP, SECCOMP_MODE_FILTER, &program) == 0)
        return;
    told->filter_errno = errno;
    _exit(EXIT_NO_FILTER);
}

/* Runs `work` behind the filter; how the child ended. */
static int behind_filter(void (*work)(run_load *), run_load *load) {
    *told = (report){.call = -1};
    fflush(NULL);
    pid_t child = fork();
    if (child < 0) exit(2);
    if (child == 0) {
        close_the_door();
        work(load);
        _exit(0);
    }
    int status = 0;
    if (waitpid(child, &status, 0) != child) exit(2);
    return WIFEXITED(status) ? WEXITSTATUS(status) : -WTERMSIG(status);
}

static void nothing(run_load *load) {
    (void)load;
}

static void asks_who_it_is(run_load *load) {
    (void)load;
    syscall(SYS_getpid);
}

static void allocates(run_load *load) {
    (void)load;
    void *volatile memory = malloc((size_t)64 << 20); /* so much comes from the kernel */
    free(memory);
}

static void solves(run_load *load) {
    for (int i = 0; i < STEPS_PER_LOAD * RUN_KINDS; i++) {
        run_load_prepare(load, i % RUN_KINDS);
        told->errors += run_load_step(load, i % RUN_KINDS) < 0;
        told->steps++;
    }
}

static int expect(const char *what, int got, int want) {
    if (got == want) return 0;
    fprintf(stderr, "%s: the child ended with %d, not %d\n", what, got, want);
    return 1;
}

int main(void) {
#ifdef SANITIZED
    printf("left out: a sanitizer makes system calls of its own\n");
    return EXIT_SKIPPED;
#endif
    told = mmap(NULL, sizeof *told, PROT_READ | PROT_WRITE, MAP_SHARED | MAP_ANONYMOUS, -1, 0);
    if (told == MAP_FAILED) return 2;
    if (behind_filter(nothing, NULL) == EXIT_NO_FILTER) {
        printf("left out: no seccomp filter here (errno %d): an emulator, or a kernel without\n",
               told->filter_errno);
        return EXIT_SKIPPED;
    }
    int bad = expect("no call", behind_filter(nothing, NULL), 0);
    bad += expect("getpid, the filter's test", behind_filter(asks_who_it_is, NULL), EXIT_CAUGHT);
    bad += expect("the call that was seen", told->call, SYS_getpid);
    bad += expect("malloc, the filter's test", behind_filter(allocates, NULL), EXIT_CAUGHT);
    int steps = 0;
    run_load load = {0};
    for (int i = 0; i < RUN_LOADS; i++) {
        run_load_open(&load, i);
        int code = behind_filter(solves, &load);
        if (code != 0 || told->errors > 0) {
            fprintf(stderr, "%s with %s: system call %d after %d steps, exit %d, %d errors\n",
                    load.part_name, load.tool_name, told->call, told->steps, code, told->errors);
            bad++;
        }
        steps += told->steps;
    }
    run_load_close(&load);
    printf("%d steps on %d pairs of part and tool, no system call\n", steps, RUN_LOADS);
    return bad > 0;
}
