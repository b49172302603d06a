/* What is looked at: part, tool, path, and what the path leaves. Long work is done beside the
 * window (job.h); nothing here draws. */
#ifndef BTG_VIEW_MODEL_H
#define BTG_VIEW_MODEL_H

extern "C" {
#include "app/options.h"
#include "bitangent/backend.h"
#include "bitangent/verify.h"
#include "io/row.h"
}

#include <atomic>
#include <glm/glm.hpp>
#include <memory>
#include <string>
#include <vector>

namespace view {

/* More are refused: a window is no place for them. */
constexpr std::size_t positions_max = 1000000;

/* Fills in a message; returns status. */
btg_status say(btg_message *message, btg_status status, const std::string &text);

/* How far long work has come, and whether it is to stop. */
struct work {
    std::atomic<std::size_t> done{0}, all{0};
    std::atomic<bool> stop{false};
};

/* Thread-safety: read-only once loaded. */
struct subject {
    std::string file; /* as given */
    btg_part *part = nullptr;
    btg_part_info info = {};
    btg_tool tool = {};
    ~subject() {
        btg_part_destroy(part);
    }
};

/* A path over a subject. */
struct tour {
    std::string file;            /* it was read from; empty: computed here */
    std::string method, backend; /* that computed it */
    std::string backend_asked;   /* "auto", say */
    std::vector<btg_row> rows;
    double seconds = 0; /* solving */
};

/* The deviation of what a path leaves from the part, as colours over x and y. */
struct field {
    int width = 0, height = 0;
    std::vector<unsigned char> rgba;        /* alpha 0: no part there; rows along +y */
    double x_mm = 0, y_mm = 0, cell_mm = 0; /* middle of the first cell */
    btg_verify_result result = {};
};

/* Loads what the options name, tool included. NULL: *message says why. */
std::shared_ptr<subject> load_subject(const path_options &options, const char *file,
                                      btg_status *status, btg_message *message);
/* Takes the cutter that a path's file names, if it does. */
btg_status take_cutter(path_options *options, const char *file, btg_message *message);
/* The path of a .csv, .cl or .ngc; where it tells no contacts they are found on the
 * part. */
std::shared_ptr<tour> load_tour(const subject &s, const path_options &options, const char *file,
                                work *w, btg_status *status, btg_message *message);
/* The path that the options ask for. */
std::shared_ptr<tour> solve_tour(const subject &s, const path_options &options, work *w,
                                 btg_status *status, btg_message *message);
/* Cuts the path into a stock; NULL when stopped, or with a message. */
std::shared_ptr<field> cut_field(const subject &s, const tour &t, const path_options &options,
                                 work *w, btg_status *status, btg_message *message);

} // namespace view

#endif
