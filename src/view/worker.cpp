#include "view/worker.h"

extern "C" {
#include "app/progress.h"
}

#include <chrono>

namespace view {

static constexpr std::chrono::milliseconds look_every(2);

static task wanted(const state &s) {
    if (!s.part) return task::none;
    if (s.recompute) return task::solve;
    bool cut = s.gouge && s.path && !s.left && !s.uncuttable;
    return cut ? task::cut : task::none;
}

static void run(worker *w) {
    if (w->doing == task::solve)
        w->path = solve_tour(*w->part, w->options, &w->progress, &w->status, &w->message);
    else
        w->left = cut_field(*w->part, *w->path, w->options, &w->progress, &w->status, &w->message);
    w->done = true;
}

static void start(worker *w, state *s, const path_options &options) {
    w->doing = wanted(*s);
    if (w->doing == task::none) return;
    w->method = s->method, w->backend = s->backend;
    w->options = options;
    w->options.method = w->method.c_str();
    w->options.backend = w->backend.c_str();
    w->part = s->part, w->path = s->path, w->left = nullptr;
    w->progress.done = w->progress.all = 0;
    w->progress.stop = w->done = false;
    w->status = BTG_OK;
    if (w->doing == task::solve) s->recompute = false;
    w->thread = std::thread(run, w);
}

/* Stopped work leaves nothing, and says nothing. */
static void hand_over(worker *w, state *s) {
    bool solved = w->doing == task::solve;
    if (w->status < 0) s->note = w->message.text;
    if (w->status < 0 && !solved) s->uncuttable = true, s->seek_gouge = false;
    if (w->status >= 0 && !w->progress.stop && w->part == s->part) {
        s->note.clear();
        bool first = solved && !s->path;
        if (solved) set_path(s, w->path);
        if (first) {
            go_to_best(s);
            look_at_tool(s);
        }
        if (!solved && w->path == s->path) set_field(s, w->left);
    }
    /* A method or back end that cannot do it is not what is shown. */
    if (s->path && !s->recompute && s->path->file.empty())
        s->method = s->path->method, s->backend = s->path->backend_asked;
    w->part = nullptr, w->path = nullptr, w->left = nullptr;
}

void worker_look(worker *w, state *s, const path_options &options) {
    if (w->doing != task::none) {
        bool stale = s->recompute || w->part != s->part;
        if (stale) w->progress.stop = true;
        s->working = w->doing == task::solve ? "solving" : "cutting";
        s->worked = w->progress.all > 0 ? double(w->progress.done) / double(w->progress.all) : 0;
        if (!w->done) return;
        w->thread.join();
        hand_over(w, s);
        w->doing = task::none;
        s->working.clear();
    }
    start(w, s, options);
}

/* Until one task is done. */
static void watch(worker *w, bool quiet) {
    while (!w->done && w->progress.all == 0)
        std::this_thread::sleep_for(look_every);
    progress bar = progress_begin(w->progress.all, quiet);
    while (!w->done) {
        std::this_thread::sleep_for(look_every);
        if (w->progress.done > 0) progress_show(&bar, w->progress.done, w->progress.done);
    }
    progress_end(&bar);
}

bool worker_finish(worker *w, state *s, const path_options &options) {
    btg_status last = BTG_OK;
    for (worker_look(w, s, options); w->doing != task::none; worker_look(w, s, options)) {
        watch(w, options.quiet);
        last = w->status;
    }
    return last >= 0;
}

void worker_stop(worker *w) {
    if (w->doing == task::none) return;
    w->progress.stop = true;
    w->thread.join();
    w->doing = task::none;
}

} // namespace view
