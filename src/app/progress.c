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

/* As 12 s, 3:05 or 1:02:03. */
static void duration(double seconds, char *text, size_t size) {
    unsigned long whole = seconds < 1e8 ? (unsigned long)(seconds + 0.5) : 100000000ul;
    if (whole < 60)
        snprintf(text, size, "%lu s", whole);
    else if (whole < 3600)
        snprintf(text, size, "%lu:%02lu", whole / 60, whole % 60);
    else
        snprintf(text, size, "%lu:%02lu:%02lu", whole / 3600, whole / 60 % 60, whole % 60);
}

static void draw(double share, double positions, double seconds) {
    char bar[BAR_WIDTH + 1], left[32];
    for (int i = 0; i < BAR_WIDTH; i++)
        bar[i] = i < share * BAR_WIDTH ? '#' : '.';
    bar[BAR_WIDTH] = '\0';
    duration(share > 0 ? seconds * (1 - share) / share : 1e9, left, sizeof left);
    fprintf(stderr, "\r[%s] %3.0f %%  %.0f positions/s  %s left\033[K", bar, 100 * share,
            positions / seconds, left);
    fflush(stderr);
}

void progress_show(progress *p, size_t done, size_t positions) {
    if (!p->shown) return;
    double now = app_seconds();
    if (now - p->begin < PATIENCE_S || now - p->last < PERIOD_S) return;
    p->last = now;
    p->drawn = true;
    double share = (double)done / (double)p->total;
    draw(share < 1 ? share : 1, (double)positions, now - p->begin);
}

void progress_end(progress *p) {
    if (p->drawn) fprintf(stderr, "\r\033[K");
    p->drawn = false;
}
