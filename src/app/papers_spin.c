/* Beyond the papers: what the spin policies gain on the same surfaces, at equal side step. The
 * VCRF paper calls contacts across the feed the optimum and leaves them open. */
#include "app/papers.h"
#include "bitangent/verify.h"
#include "core/part.h"

#include <stdlib.h>

static const char table[] = "Spin policies: strip and scallop, side step 18 mm";
#define PASS_FEET 76
#define QUICK_PASS                                                                                 \
    4 /* the one that --quick looks at; on the first the part ends beside the tool                 \
       */
#define SCALLOP_MM 0.01
#define CELL_MM    0.5
#define PART_MM    150.0

typedef struct policy {
    const char *name;
    btg_spin spin;
} policy;

#define POLICIES 4
static const policy policies[POLICIES] = {{"none", BTG_SPIN_NONE},
                                          {"gap:6", BTG_SPIN_GAP},
                                          {"across", BTG_SPIN_ACROSS},
                                          {"widest", BTG_SPIN_WIDEST}};

typedef struct outcome {
    double strip_mm; /* mean of btg_position_strip */
    double left_mm,
        finished_mm; /* by verification: mean left, surface within the scallop by length */
    double gouge_mm; /* of the motion between positions */
} outcome;

/* A whole path, each position from its neighbour on the pass: so the spin stays near. */
static btg_status solve_path(const papers *p, int surface, const btg_solver_def *solver,
                             const double *xy, size_t count, btg_position *out) {
    const btg_part *part = p->part[surface];
    size_t size = btg_position_workspace_size(part);
    void *workspace = malloc(size);
    btg_status status = workspace ? BTG_OK : BTG_ERROR_MEMORY;
    for (size_t i = 0; i < count && status >= 0; i++)
        status =
            btg_position_follow(part, &p->tool, solver, xy[2 * i], xy[2 * i + 1],
                                i % PASS_FEET > 0 ? &out[i - 1] : NULL, workspace, size, &out[i]);
    free(workspace);
    return status < 0 ? status : BTG_OK;
}

static btg_status cut(papers *p, int surface, const btg_position *path, size_t count,
                      btg_verify_result *result) {
    btg_verify_def def = btg_verify_def_default();
    btg_verify *verify = NULL;
    def.cell_mm = CELL_MM;
    def.scallop_mm = SCALLOP_MM;
    def.prove = 0;
    btg_status status = btg_verify_create(&def, p->part[surface], &p->tool, &verify, &p->message);
    for (size_t i = 0; i < count && status >= 0; i++) {
        btg_verify_pose pose = {.tip = path[i].tip, .axis = path[i].axis};
        if (path[i].status == BTG_NO_CONTACT) continue;
        pose.link = i % PASS_FEET > 0;
        status = btg_verify_add(verify, &pose);
    }
    if (status >= 0) status = btg_verify_end(verify, result);
    btg_verify_destroy(verify);
    return status < 0 ? status : BTG_OK;
}

static btg_status measure(papers *p, int surface, const policy *of, const double *xy, size_t count,
                          btg_position *path, outcome *o) {
    btg_solver_def solver = p->solver;
    btg_verify_result result;
    solver.spin = of->spin;
    solver.gap_mm = 6;
    solver.scallop_mm = SCALLOP_MM;
    papers_show(p, "strips of the spin policies");
    btg_status status = solve_path(p, surface, &solver, xy, count, path);
    double strip = 0;
    for (size_t i = 0; i < count && status == BTG_OK; i++) {
        double width = 0;
        status = btg_position_strip(p->part[surface], &p->tool, &solver, &path[i], &width);
        strip += width / (double)count;
    }
    if (status == BTG_OK) status = cut(p, surface, path, count, &result);
    if (status == BTG_OK)
        *o = (outcome){strip, result.mean_scallop_mm, result.strip_width_mm, result.max_gouge_mm};
    return status;
}

static void add(papers *p, int surface, const policy *of, const outcome *o, const outcome *none) {
    const char *item = papers_surface[surface];
    double passes = ceil(PART_MM / o->strip_mm), before = ceil(PART_MM / none->strip_mm);
    papers_name(papers_add(p, table, "mm", o->strip_mm, NAN), item, "%s: strip, mean", of->name);
    papers_name(papers_add(p, table, "", passes, NAN), item, "%s: passes for 0.01 mm", of->name);
    papers_name(papers_add(p, table, "", before - passes, NAN), item, "%s: passes fewer", of->name);
    papers_name(papers_add(p, table, "mm", o->finished_mm, NAN), item,
                "%s: cut strip within 0.01 mm", of->name);
    papers_name(papers_add(p, table, "mm", o->left_mm, NAN), item, "%s: left, mean", of->name);
    papers_name(papers_add(p, table, "mm", o->gouge_mm, NAN), item, "%s: gouge between positions",
                of->name);
}

btg_status papers_spin(papers *p) {
    size_t count;
    double *feet = papers_footprint(1, &count);
    const double *xy = feet;
    if (p->quick && feet) {
        xy += 2 * QUICK_PASS * PASS_FEET;
        count = PASS_FEET;
    }
    btg_position *path = malloc((xy ? count : 1) * sizeof *path);
    btg_status status = xy && path ? BTG_OK : BTG_ERROR_MEMORY;
    for (int surface = 0; surface < PAPERS_SURFACES && status == BTG_OK; surface++) {
        outcome o[POLICIES];
        for (int k = 0; k < POLICIES && status == BTG_OK; k++) {
            status = measure(p, surface, &policies[k], xy, count, path, &o[k]);
            if (status == BTG_OK) add(p, surface, &policies[k], &o[k], &o[0]);
        }
    }
    free(feet);
    free(path);
    papers_note_add(
        p, table,
        "strip: what one pass leaves within 0.01 mm, by btg_position_strip, mean over "
        "%zu positions in %s; passes: 150 mm by it. The cut strip is what verification finds "
        "finished, by length of the path, which grows where the tip swings; what is left "
        "is at 18 mm, wider than any strip, and more where the tool leans to one side%s.",
        count, p->quick ? "one pass near the middle" : "all passes",
        p->quick ? "; with one pass it is nearly all of the part" : "");
    papers_note_add(
        p, table,
        "Positions are gouge-free one by one. A policy that changes the spin from one "
        "to the next swings the tool, and the motion between, 2 mm apart here, cuts: the "
        "gouge column. Shorter steps mend it.");
    if (status < 0)
        btg_fail(&p->message, status, "bench: the spin policies failed (%s)",
                 btg_status_name(status));
    return status;
}
