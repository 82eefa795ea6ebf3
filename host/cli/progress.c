/* SPDX-License-Identifier: MIT
 *
 * Interruption and progress: SIGINT, SIGTERM and SIGHUP make the progress callback ask the library
 * to stop, which then ends with nothing half-written; a bar or a line is drawn on stderr when that
 * is a terminal.
 */
#define _POSIX_C_SOURCE 200809L
#include "cli/cli.h"

#include <signal.h>
#include <string.h>
#include <unistd.h>

#define BAR  40
#define LINE 99

static volatile sig_atomic_t interrupted;
static int drawn = -1; /* percent shown, -1 = no bar on the terminal */

static void on_interrupt(int signal_number) {
    (void)signal_number;
    interrupted = 1;
}

void cli_catch_interrupt(void) {
    static const int signals[] = {SIGINT, SIGTERM, SIGHUP};
    struct sigaction action = {.sa_handler = on_interrupt, .sa_flags = (int)SA_RESETHAND};
    struct sigaction old;
    sigemptyset(&action.sa_mask);
    for (size_t i = 0; i < sizeof signals / sizeof *signals; i++)
        if (sigaction(signals[i], NULL, &old) == 0 && old.sa_handler != SIG_IGN)
            sigaction(signals[i], &action, NULL); /* ignored, as in the background: stay deaf */
}

int cli_interrupted(void) {
    return interrupted != 0;
}

static int is_terminal(void) {
    static int terminal = -1;
    if (terminal < 0)
        terminal = isatty(STDERR_FILENO);
    return terminal;
}

strata_result cli_progress(void *user, double done) {
    (void)user;
    int percent = done >= 1.0 ? 100 : done > 0.0 ? (int)(done * 100.0) : 0;
    if (is_terminal() && percent != drawn) {
        static const char full[] = "########################################";
        fprintf(stderr, "\r[%-*.*s] %3d %%", BAR, percent * BAR / 100, full, percent);
        fflush(stderr);
        drawn = percent;
    }
    return interrupted ? STRATA_ERROR_CANCELLED : STRATA_OK;
}

void cli_progress_line(const char *text) {
    if (!is_terminal())
        return;
    fprintf(stderr, "\r%-*.*s", LINE, LINE, text);
    fflush(stderr);
    drawn = 0;
}

void cli_progress_end(void) {
    if (drawn >= 0)
        fprintf(stderr, "\r%*s\r", LINE, "");
    drawn = -1;
}
