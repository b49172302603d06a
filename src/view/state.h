/* What the user sees and where in the path they are: everything that keys, mouse and panel change,
 * whatever the window. */
#ifndef BTG_VIEW_STATE_H
#define BTG_VIEW_STATE_H

#include "view/camera.h"
#include "view/model.h"

#include <string>

namespace view {

enum class tool_look { solid, clear, hidden };

struct state {
    std::shared_ptr<subject> part;
    std::shared_ptr<tour> path;
    std::shared_ptr<field> left; /* of `path`; NULL until it is cut */

    std::size_t at = 0; /* row of the path */
    bool playing = false;
    double speed = 30;   /* positions a second */
    double progress = 0; /* toward the next position while playing */

    tool_look tool = tool_look::solid;
    bool normals = false, insert = false, ray = false, gouge = false;
    bool seek_gouge = false;        /* go where most is gouged as soon as that is known */
    bool lean = true, trail = true; /* axis before and after the tilt; where contacts were */
    bool follow = true;             /* the camera goes with the tool */
    bool panel = true, help = true;

    camera eye;
    double aspect = 1.6;
    std::string note; /* one line for the user: an error, a file written */

    /* What is to be done beside the window. */
    bool quit = false, save_picture = false;
    bool recompute = false;
    std::string method = "vcrf", backend = "auto";
    bool uncuttable = false; /* the path and the part cannot be cut into a field */
    std::string working;     /* what is being done there; empty: nothing */
    double worked = 0;       /* 0 .. 1 of it */
    std::string dropped;     /* a file that was dropped on the window */
};

/* The row shown; NULL without a path. */
const btg_row *current(const state &s);

void go_to(state *s, std::size_t row);
void step(state *s, long rows);
/* To the first position of the next pass (+1) or of this or the one before (-1). */
void step_pass(state *s, int direction);
/* Moves on by `seconds` while playing; stops at the end. */
void advance(state *s, double seconds);

/* To a position where there is much to see, in the middle of the part rather than at its edge. */
void go_to_best(state *s);

/* The field that the path leaves is known; goes to its deepest gouge when that is wanted. */
void set_field(state *s, std::shared_ptr<field> left);

/* s->dropped: a part, over which a path is then solved, or a path over this part. */
void open_dropped(state *s, const path_options &options);

/* A new path: the camera and the row stay where they fit. */
void set_path(state *s, std::shared_ptr<tour> path);

/* Of the tool's outer radius: how much of its surroundings look_at_tool shows. */
constexpr double surroundings = 2.2;

/* Where the camera looks: near the tool, or at the whole part with the tool. */
void look_at_tool(state *s);
void look_at_part(state *s);
/* "iso", "top", "front", "back", "left", "right", "tilt" (along the axis about which the tool
 * tilted: P, Q and the tilt in true size) or AZIMUTH,ELEVATION in degrees. False: no such. */
bool look_from(state *s, const char *name);
bool view_name_known(const char *name);

/* One key by its name, as --keys takes it: "space", "left", "n", ...; "drop:FILE" drops a
 * file. False: no such key. */
bool press(state *s, const std::string &key);
bool key_known(const std::string &key);

/* What can be chosen: back ends that are ready, "auto" first; methods. */
std::vector<std::string> backend_names();
std::vector<std::string> method_names();
/* The path is to be solved again by it. A method that works by itself and a back end exclude each
 * other: the one chosen last counts. */
void choose_method(state *s, const std::string &name);
void choose_backend(state *s, const std::string &name);

struct key_help {
    const char *keys, *meaning;
};
extern const key_help key_list[];
extern const std::size_t key_count;

} // namespace view

#endif
