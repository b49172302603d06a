/* The search for a spin: policies gap, across and widest. Internal.
 *
 * One TILT query after the other, each with the tool spun by another angle about the first
 * contact's normal; whoever owns the search asks them, one by one (spin.c's position calls) or in
 * rounds over many positions (back ends):
 *
 *     btg_spin_begin(&search, ...);
 *     while (btg_spin_next(&search, &query)) { ask; btg_spin_take(&search, &query, &result); }
 *     btg_spin_finish(&search, ...);
 */
#ifndef BTG_CORE_SPIN_H
#define BTG_CORE_SPIN_H

#include "core/strip.h"

/* Tilts a position at the most. */
#define BTG_SPIN_TILTS_MAX 24

/* One spin that was tried. */
typedef struct btg_spin_sample {
    double alpha;     /* rad, -pi .. pi */
    double value;     /* gap: |PQ| - gap, mm; across: angle off a right one, rad; widest: width, mm;
                         NaN: no second contact */
    double heading;   /* direction of Q from P, as a spin: where Q lies under the tool's centre */
    double half;      /* turn from the heading that should meet the aim; NaN: not known */
    double crest;     /* widest: greatest clearance between P and Q, a part of the scallop */
    double off_crest; /* widest: the logarithm of that, from the crest aimed at */
    double could;     /* widest: about the width there */
    double tilt;      /* rad */
    btg_place q;      /* of the second contact */
    bool has_q;
    bool guessed; /* by the way uphill from a neighbour's Q alone: a lower tilt may not be free */
} btg_spin_sample;

typedef struct btg_spin_search {
    const btg_part *part;
    const btg_tool *tool;
    const btg_solver_def *solver;
    btg_tilt_query unspun;
    double start, asked; /* spin to begin near; spin of the query out now */
    bool local;          /* begun from a neighbour's spin */
    uint32_t count, polishes;
    bool any;        /* a sample has a score, the best of them is best_score */
    bool may_guess;  /* the query out now starts at the Q of a spin nearby */
    bool redo;       /* that said nothing: the same query in full */
    uint32_t misled; /* guesses that were wrong */
    btg_place q;     /* near the first query's second contact, where has_q */
    bool has_q;
    double best_score;
    double proven_alpha, proven_score; /* of those that are not guessed */
    btg_tilt_result proven;
    btg_spin_sample sample[BTG_SPIN_TILTS_MAX];
    /* of the spin that is being judged: off the stack */
    btg_spin_sample fresh;
    btg_strip_query strip;
} btg_spin_search;

static inline bool btg_spin_searches(const btg_solver_def *solver) {
    return solver->spin == BTG_SPIN_GAP || solver->spin == BTG_SPIN_ACROSS ||
           solver->spin == BTG_SPIN_WIDEST;
}

/* `unspun` is the query of btg_position_tilt_query; `start` the spin of a neighbour, or NaN. All
 * pointers are kept. */
void btg_spin_begin(btg_spin_search *search, const btg_part *part, const btg_tool *tool,
                    const btg_solver_def *solver, const btg_tilt_query *unspun, double start);
/* The next query to ask; false: the search is over. Where search->may_guess is set, the answer may
 * be that of tilt_near (run.h), `guessed`; the best is asked once more in full at the end. */
bool btg_spin_next(btg_spin_search *search, btg_tilt_query *query);
/* Its answer. */
void btg_spin_take(btg_spin_search *search, const btg_tilt_query *query,
                   const btg_tilt_result *result, bool guessed);
/* The position of the best spin found; the status, or an error, as btg_position_assemble. */
btg_status btg_spin_finish(const btg_spin_search *search, double foot_x_mm, double foot_y_mm,
                           const btg_drop_query *drop_query, const btg_drop_result *drop,
                           btg_position *position);

/* As btg_tilt, but uphill from query->start alone: not proven, bound_mm infinite. (solver.c) */
btg_status btg_tilt_near(const btg_part *part, const btg_tool *tool, const btg_solver_def *solver,
                         const btg_tilt_query *query, void *workspace, size_t workspace_size,
                         btg_tilt_result *result);

/* ---- position.c --------------------------------------------------------------------------- */

/* The frame of a TILT query turned by alpha about nP, and laid over; alpha 0: as it is. */
void btg_position_spin(double alpha, btg_tilt_query *frame);
/* The placed tool after a turn by beta. */
void btg_position_pose(const btg_tool *tool, const btg_tilt_query *frame, double beta,
                       btg_vec3 *centre, btg_vec3 *axis);

#endif
