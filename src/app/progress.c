#define _GNU_SOURCE
#include "app/progress.h"
#include "app/app.h"

#include <stdio.h>
#include <unistd.h>

#define BAR_WIDTH  30
#define PERIOD_S   0.1 /* between two drawings */
#define PATIENCE_S 0.3 /* shorter work shows nothing */

progress progress_begin(size_t total, bool quiet) {
    progress p = {.total = total};
    p.shown = !quiet && total > 0 && isatty(STDERR_FILENO);
    p.begin = p.last = app_seconds();
    return p;
}

static void draw(size_t done, size_t total, double seconds) {
    char bar[BAR_WIDTH + 1];
    double share = (double)done / (double)total;
    double rate = (double)done / seconds;
    double left = rate > 0 ? (double)(total - done) / rate : 0;
    for (int i = 0; i < BAR_WIDTH; i++)
        bar[i] = i < share * BAR_WIDTH ? '#' : '.';
    bar[BAR_WIDTH] = '\0';
    fprintf(stderr, "\r[%s] %3.0f %%  %.0f positions/s  %.0f s left \033[K", bar, 100 * share, rate,
            left);
    fflush(stderr);
}

void progress_show(progress *p, size_t done) {
    if (!p->shown) return;
    double now = app_seconds();
    if (now - p->begin < PATIENCE_S || now - p->last < PERIOD_S) return;
    p->last = now;
    p->drawn = true;
    draw(done, p->total, now - p->begin);
}

void progress_end(progress *p) {
    if (p->drawn) fprintf(stderr, "\r\033[K");
    p->drawn = false;
}
