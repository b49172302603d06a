/* Parts of the post-processor; see bitangent/post.h. Internal.
 *
 * A position goes through: choose (which solution, which turn) -> program (travels, cuts) ->
 * refine (more points where the machine's own interpolation strays) -> pace (how long each move
 * takes) -> gcode (text). */
#ifndef BTG_POST_INTERNAL_H
#define BTG_POST_INTERNAL_H

#include "bitangent/post.h"
#include "core/part.h"

/* ---- number.c ----------------------------------------------------------------------------- */

#define BTG_NUMBER_MAX  1e9 /* largest number written: nine decimals of it fit a 64-bit integer */
#define BTG_NUMBER_SIZE 32  /* characters of the longest */

/* Largest number of decimals. */
#define BTG_DECIMALS_MAX 9

/* value * 10^decimals, rounded. */
int64_t btg_number_scaled(double value, int decimals);
/* `scaled` / 10^decimals as text, not terminated; returns its end. Decimals that are 0 are left
 * out down to `least`. Written by hand: printf's decimal point follows the locale. */
char *btg_number_text(char *text, int64_t scaled, int decimals, int least);

/* ---- machine.c ---------------------------------------------------------------------------- */

/* The rotary angles of both solutions, in -pi..pi. *free_axis: the rotary that may stand anyhow
 * because the axis is the pole (it is given as 0), or -1. False: out of reach. `cone`: an axis
 * closer to the pole than this angle is taken for the pole. */
bool btg_machine_angles(const btg_machine *machine, btg_vec3 axis, double cone, double angle[2][2],
                        int *free_axis);
/* The linear joints for given rotary ones. */
btg_vec3 btg_machine_linear(const btg_machine *machine, btg_vec3 tip, const double angle[2]);
/* The tool's axis in the part frame. */
btg_vec3 btg_machine_axis(const btg_machine *machine, const double angle[2]);
/* Tip from joints. */
btg_vec3 btg_machine_tip(const btg_machine *machine, btg_vec3 linear, const double angle[2]);
/* The first linear joint beyond its limits, or -1. */
int btg_machine_beyond(const btg_machine *machine, btg_vec3 linear);

static inline double vec_at(btg_vec3 a, int i) {
    return i == 0 ? a.x : i == 1 ? a.y : a.z;
}

/* Limits hold to the last digit that a program could show. */
#define BTG_LIMIT_SLACK_RAD 1e-9
#define BTG_LIMIT_SLACK_MM  1e-6

/* ---- choose.c ----------------------------------------------------------------------------- */

/* Two solutions, times the turns a rotary joint can make within limits of up to three of them. */
#define BTG_STATES_MAX 50

typedef struct btg_choice_node {
    btg_vec3 tip, axis;
    double base[2][2]; /* rotary angles of both solutions, in -pi..pi */
    int8_t free_axis;
    bool linked; /* cut from the node before; else reached by a retract */
    bool usable[2];
    bool gap; /* decided: not linked after all, a limit lies between this node and the last */
    uint8_t arrive, leave;            /* chosen: states */
    double arrive_at[2], leave_at[2]; /* and their angles; they differ where a rewind is needed */
} btg_choice_node;

/* One column of the dynamic program. */
typedef struct btg_column {
    double cost[BTG_STATES_MAX]; /* INFINITY: not possible */
    double at[BTG_STATES_MAX][2];
} btg_column;

typedef struct btg_choice {
    const btg_machine *machine;
    double cone_rad;
    int turns[2];      /* turns that are tried, per rotary joint; 0: the nearest one alone */
    bool wide[2];      /* the two are: the nearest, and back to the middle of the limits */
    int first_turn[2]; /* the lowest of them */
    int states;
    size_t capacity, count;
    bool settled; /* node 0 was decided before: it is where the machine is */
    btg_choice_node *nodes;
    uint8_t *from;   /* by node and state: the state the one before was left in */
    uint8_t *rewind; /* by node and state: the state it was reached in, when left in this one */
    btg_column now, turned;
} btg_choice;

btg_status btg_choice_open(btg_choice *choice, const btg_machine *machine, double cone_rad,
                           size_t window, const btg_allocator *allocator);
void btg_choice_close(btg_choice *choice, const btg_allocator *allocator);
/* The next node; there is room for it. ERROR_UNSUPPORTED with a message: out of reach. */
btg_status btg_choice_add(btg_choice *choice, btg_vec3 tip, btg_vec3 axis, bool linked,
                          btg_message *message);
/* Decides all nodes that are there. */
void btg_choice_settle(btg_choice *choice);
/* After settle: forgets all but the last node. */
void btg_choice_forget(btg_choice *choice);
/* Within the rotary limits. */
bool btg_choice_allowed(const btg_machine *machine, const double angle[2]);
/* Of two solutions and all turns the angles nearest to `near`. */
bool btg_choice_nearest(const btg_machine *machine, btg_vec3 axis, double cone,
                        const double near[2], double angle[2]);

/* ---- the program --------------------------------------------------------------------------- */

/* A point of the motion. */
typedef struct btg_stop {
    btg_vec3 tip, axis;
    double angle[2];
} btg_stop;

/* One cutting block: to `end`, in `seconds`. */
typedef struct btg_move {
    btg_stop end;
    double joint[5];  /* at the end: mm, radians */
    double delta[5];  /* from the end before */
    double length_mm; /* of the tip's way */
    double seconds, wanted_seconds;
} btg_move;

/* Cutting blocks whose times are fitted together; three quarters of them leave at a time. */
#define BTG_MOVES_MAX 1024

#define BTG_TEXT_SIZE 65536

struct btg_program {
    btg_program_def def;
    btg_machine machine;
    btg_tool tool;
    btg_choice choice;
    btg_program_info info;
    btg_status status; /* the first error, and what is to be said about it */
    btg_message message;
    double reach_mm; /* of the cutter about the tip: an axis' error times this is the cutter's */
    double axis_tolerance_rad;
    bool started, broken;
    btg_stop at; /* where the machine stands, once started */

    /* pace */
    btg_move moves[BTG_MOVES_MAX];
    int move_count;
    int moves_fixed; /* the first ones have left already; they are there for their speed */
    btg_stop paced;  /* where the last of the moves ends */
    double paced_joint[5];

    /* gcode */
    char name[32];
    int decimals_mm, decimals_deg;
    int64_t last[6]; /* words as written last: X Y Z and the rotary ones or the vector */
    bool known[6];
    int motion; /* G0, G1, or -1 */
    double last_feed;
    uint64_t lines; /* written, comments apart */
    unsigned long line;
    size_t text_size;
    char text[BTG_TEXT_SIZE];
};

/* From wherever it is over the part to `b`, the last bit as a cut. */
void btg_travel(btg_program *program, const btg_stop *b);

/* ---- refine.c ----------------------------------------------------------------------------- */

/* Hands the way from `a` to `b` to pace in pieces that stay within the tolerance. */
void btg_refine(btg_program *program, const btg_stop *a, const btg_stop *b);
/* How far the machine's way from a to b strays from the straight one: tip mm, axis radians. */
void btg_stray(const btg_program *program, const btg_stop *a, const btg_stop *b, double *tip_mm,
               double *axis_rad);
/* The point half-way that the path asks for. */
btg_stop btg_middle(const btg_program *program, const btg_stop *a, const btg_stop *b);

/* ---- pace.c ------------------------------------------------------------------------------- */

/* A cut starts at `stop`, from rest. */
void btg_pace_start(btg_program *program, const btg_stop *stop);
void btg_pace_add(btg_program *program, const btg_stop *stop);
/* Writes all that is left. */
void btg_pace_drain(btg_program *program);
/* Shortest time of one move by joint speeds and, rest to rest, accelerations. Looks at limits. */
double btg_pace_alone(btg_program *program, const btg_stop *a, const btg_stop *b);

/* ---- gcode.c ------------------------------------------------------------------------------ */

void btg_gcode_begin(btg_program *program);
/* Where the machine goes first: rotary joints, then over the part, from a place not known. */
void btg_gcode_first(btg_program *program, const btg_stop *stop);
void btg_gcode_rapid(btg_program *program, const btg_stop *stop);
void btg_gcode_cut(btg_program *program, const btg_stop *stop, double seconds, double length_mm,
                   double turn_rad);
void btg_gcode_end(btg_program *program);
void btg_gcode_flush(btg_program *program);

/* The first error counts. */
void btg_program_latch(btg_program *program, btg_status status);

#endif
