/* Long work beside the window: solving the path again, cutting it into a stock. */
#ifndef BTG_VIEW_WORKER_H
#define BTG_VIEW_WORKER_H

#include "view/state.h"

#include <thread>

namespace view {

enum class task { none, solve, cut };

struct worker {
    task doing = task::none;
    std::thread thread;
    work progress;
    std::atomic<bool> done{false};
    /* What it works on and with, kept alive; what came of it. */
    path_options options = {};
    std::string method, backend;
    std::shared_ptr<subject> part;
    std::shared_ptr<tour> path;
    std::shared_ptr<field> left;
    btg_status status = BTG_OK;
    btg_message message = {};
};

/* Hands over what is finished, stops what is no longer wanted, starts what is. Call each frame. */
void worker_look(worker *w, state *s, const path_options &options);
/* The same until there is nothing left to do, with its progress on a terminal. False: the last work
 * failed; s->note and w->status say why. */
bool worker_finish(worker *w, state *s, const path_options &options);
/* Ends it, whatever it does. */
void worker_stop(worker *w);

} // namespace view

#endif
