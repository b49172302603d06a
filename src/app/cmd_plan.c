/* `bitangent plan`: how finely to sample for a tolerance. */
#include "app/app.h"
#include "app/plan.h"
#include "core/part.h"
#include "io/chart.h"
#include "io/json.h"
#include "io/picture.h"

#include <string.h>

/* Errors a smaller part of their bounds than that say that the model is of no use. */
#define LOOSE 0.1
/* Any window of one level tells whether bounds hold; wider ones only take longer. */
#define MODEL_MAX 160
/* Two levels: a window that misses the valley is made that much wider, up to so many pixels. */
#define WIDEN     1.25
#define WIDEN_MAX 256
/* Windows of the trade-off curve. */
#define CURVE 24

/* Options of `bitangent path` that mean the same here. */
static const char *const borrowed[] = {"--tool", "--tolerance", "--gltf-unit", "--up", "--use-mesh",
                                       "--json", "--quiet",     "--help",      "-h"};

typedef struct words {
    int count, next;
    char **list;
    const char *picture; /* -o; NULL: none */
    path_options path;
} words;

typedef struct curve {
    plan_way way[2][CURVE]; /* by levels */
    double x[2][CURVE], y[2][CURVE];
} curve;

/* ---- the command line --------------------------------------------------------------------- */

static const option *find(const char *word, size_t size) {
    bool known = false;
    for (size_t i = 0; i < sizeof borrowed / sizeof *borrowed; i++)
        known = known || (strlen(borrowed[i]) == size && strncmp(borrowed[i], word, size) == 0);
    for (size_t i = 0; i < path_option_count && known; i++)
        if (strlen(path_option_list[i].name) == size &&
            strncmp(path_option_list[i].name, word, size) == 0)
            return &path_option_list[i];
    return NULL;
}

static bool set_picture(words *w, const char *name, const char *path) {
    size_t size = strlen(path);
    const char *end = size > 4 ? path + size - 4 : "";
    if (strcmp(end, ".png") != 0 && strcmp(end, ".svg") != 0)
        return app_refuse(name, "'%.200s'; a file that ends in .png or .svg", path);
    if (!btg_picture_available())
        return app_refuse(name, "this build draws no pictures; install libcairo2-dev and build "
                                "again");
    w->picture = path;
    return true;
}

static bool take_option(words *w, const char *word) {
    const char *equals = strncmp(word, "--", 2) == 0 ? strchr(word, '=') : NULL;
    size_t size = equals ? (size_t)(equals - word) : strlen(word);
    bool own = (size == 2 && strncmp(word, "-o", 2) == 0) ||
               (size == 8 && strncmp(word, "--output", 8) == 0);
    const option *x = own ? NULL : find(word, size);
    if (!own && !x)
        return app_refuse("plan", "unknown option '%.200s'; see 'bitangent help plan'", word);
    if (x && x->flag && equals) return app_refuse(x->name, "takes no value");
    if (x && x->flag) return x->set(&w->path, x->name, NULL);
    const char *name = own ? "-o" : x->name;
    const char *value = equals ? equals + 1 : w->next < w->count ? w->list[w->next++] : NULL;
    if (!value) return app_refuse(name, "needs a value; see 'bitangent help plan'");
    return own ? set_picture(w, name, value) : x->set(&w->path, name, value);
}

static bool parse(words *w) {
    while (w->next < w->count && !w->path.help) {
        const char *word = w->list[w->next++];
        if (word[0] == '-' && word[1] != '\0') {
            if (!take_option(w, word)) return false;
        } else if (w->path.part) {
            return app_refuse("plan", "two parts, '%.200s' and '%.200s'; give one", w->path.part,
                              word);
        } else {
            w->path.part = word;
        }
    }
    if (w->path.help || w->path.part) return true;
    return app_refuse("plan", "no part; give a glTF file, see 'bitangent help plan'");
}

/* ---- what comes out ----------------------------------------------------------------------- */

static const plan_way *cheaper(const plan *p) {
    return p->two.pixels < p->one.pixels ? &p->two : &p->one;
}

/* The model: no error above its bound, and the bounds no more than so many times too large. What is
 * taken: no error above the pixels' share of the tolerance. */
static bool model_holds(const plan *p) {
    return !p->model.backend || (p->model.share <= 1 && p->model.share >= LOOSE);
}

static bool taken_holds(const plan *p) {
    return !p->check.backend || p->check.measured_mm <= p->pixel_share_mm;
}

/* The second level looks two pixels of the first about its winner. Where the drop is flat the true
 * contact may lie farther off, which the model does not say: the window is widened until what is
 * measured keeps the share. */
static btg_status settle(const path_options *o, const btg_part *part, const btg_tool *tool, plan *p,
                         btg_message *message) {
    plan_way one = p->one.window > MODEL_MAX ? plan_way_of(tool, p, MODEL_MAX, 1) : p->one;
    btg_status status = plan_measure(part, tool, &o->solver, p, &one, &p->model, message);
    p->taken = *cheaper(p);
    while (status == BTG_OK) {
        status = plan_measure(part, tool, &o->solver, p, &p->taken, &p->check, message);
        bool wide = p->taken.levels == 1 || p->taken.window >= WIDEN_MAX;
        if (status != BTG_OK || taken_holds(p) || wide) break;
        uint32_t window = (uint32_t)ceil(p->taken.window * WIDEN);
        p->taken = plan_way_of(tool, p, window, 2);
    }
    return status;
}

static bool holds(const plan *p) {
    return model_holds(p) && taken_holds(p);
}

static void print_way(FILE *file, const char *name, const plan_way *w) {
    fprintf(file,
            "%-11s %u x %u pixels, %.4g mm apart, error at most %.3g mm, %.3g pixels a drop\n",
            name, w->window, w->window, w->pitch_mm, w->bound_mm, w->pixels);
}

static void print_plan(const plan *p, const path_options *o, FILE *file) {
    const plan_check *c = &p->check;
    fprintf(file, "part        %s: slope up to %.1f deg, radius of curvature from %.4g mm\n",
            o->part, p->part.slope_rad * (180 / BTG_PI), p->part.radius_mm);
    fprintf(file,
            "tolerance   %.4g mm: pixels %.4g, facets of the tool %.4g, of the part %.4g mm\n",
            o->solver.tolerance_mm, p->pixel_share_mm, p->tool_share_mm, p->part_share_mm);
    if (p->rounding_mm > 0)
        fprintf(file, "rounding    %.2g mm of the pixels': depth images are in single precision\n",
                p->rounding_mm);
    print_way(file, "one level", &p->one);
    print_way(file, "two levels", &p->two);
    fprintf(file, "take        --method depth --levels %d --window %u%s\n", p->taken.levels,
            p->taken.window,
            p->taken.window > cheaper(p)->window ? ", wider: less misses the valley" : "");
    fprintf(file,
            "tool        facets of %.4g mm: %.0f around the insert, %.0f around the tool, "
            "%.3g triangles\n",
            p->rim.length_mm, p->insert.count, p->rim.count, p->rim.triangles);
    if (p->part.triangles)
        fprintf(file, "part        is triangles already\n");
    else
        fprintf(file, "part        facets of %.4g mm: %.3g triangles\n", p->surface.length_mm,
                p->surface.triangles);
    if (!c->backend) {
        fprintf(file, "checked     not: no back end here drops this part by so many pixels\n");
        return;
    }
    fprintf(file,
            "checked     by %s; one level, %zu drops: deepest %.3g mm, bounds at least %.1f "
            "times the error: %s\n",
            p->model.backend, p->model.places, p->model.measured_mm, 1 / p->model.share,
            model_holds(p) ? "holds" : "DOES NOT HOLD");
    fprintf(file, "            as taken, %zu drops: deepest %.3g mm of %.3g allowed: %s\n",
            c->places, c->measured_mm, p->pixel_share_mm,
            taken_holds(p) ? "holds" : "DOES NOT HOLD");
    fprintf(file, "time        %.3g s a position, %.3g s for 1000\n", c->seconds,
            1000 * c->seconds);
}

static void json_way(btg_json *json, const char *name, const plan_way *w) {
    btg_json_open(json, name, '{');
    btg_json_count(json, "levels", (uint64_t)w->levels);
    btg_json_count(json, "window", w->window);
    btg_json_number(json, "pitch_mm", w->pitch_mm);
    btg_json_number(json, "bound_mm", w->bound_mm);
    btg_json_number(json, "pixels", w->pixels);
    btg_json_close(json, '}');
}

static void print_json(const plan *p, const path_options *o, const curve *c, btg_output *out) {
    btg_json json = btg_json_to(out);
    btg_json_open(&json, NULL, '{');
    btg_json_number(&json, "tolerance_mm", o->solver.tolerance_mm);
    btg_json_number(&json, "slope_deg", p->part.slope_rad * (180 / BTG_PI));
    btg_json_number(&json, "radius_mm", p->part.radius_mm);
    btg_json_number(&json, "rounding_mm", p->rounding_mm);
    json_way(&json, "one_level", &p->one);
    json_way(&json, "two_levels", &p->two);
    json_way(&json, "taken", &p->taken);
    btg_json_number(&json, "tool_facets_around_insert", p->insert.count);
    btg_json_number(&json, "tool_facets_around", p->rim.count);
    btg_json_number(&json, "tool_triangles", p->rim.triangles);
    btg_json_number(&json, "part_facet_mm", p->part.triangles ? NAN : p->surface.length_mm);
    btg_json_number(&json, "part_triangles", p->part.triangles ? NAN : p->surface.triangles);
    btg_json_open(&json, "check", '{');
    btg_json_string(&json, "backend", p->check.backend ? p->check.backend : "none");
    btg_json_number(&json, "model_measured_mm", p->model.measured_mm);
    btg_json_number(&json, "model_share_of_bound", p->model.share);
    btg_json_number(&json, "measured_mm", p->check.measured_mm);
    btg_json_number(&json, "allowed_mm", p->pixel_share_mm);
    btg_json_number(&json, "seconds_per_position", p->check.seconds);
    btg_json_bool(&json, "holds", holds(p));
    btg_json_close(&json, '}');
    btg_json_open(&json, "curve", '[');
    for (int k = 0; k < 2 * CURVE; k++)
        json_way(&json, NULL, &c->way[k / CURVE][k % CURVE]);
    btg_json_close(&json, ']');
    btg_json_close(&json, '}');
    btg_output_text(out, "\n");
}

/* ---- the trade-off ------------------------------------------------------------------------ */

static void trade(const btg_tool *tool, const plan *p, curve *c) {
    for (int levels = 1; levels <= 2; levels++)
        for (int i = 0; i < CURVE; i++) {
            double most = levels == 1 ? 512 : 24; /* times 8 pixels */
            uint32_t window = (uint32_t)(8 * pow(most, (double)i / (CURVE - 1)) + 0.5);
            plan_way w = plan_way_of(tool, p, window, levels);
            c->way[levels - 1][i] = w;
            c->x[levels - 1][i] = log10(w.pixels);
            c->y[levels - 1][i] = log10(w.bound_mm);
        }
}

static btg_status draw(const plan *p, const path_options *o, const curve *c, const char *path,
                       btg_message *message) {
    char title[64];
    double x[2] = {c->x[0][0], c->x[0][CURVE - 1]}, share = log10(p->pixel_share_mm);
    double y[2] = {share, share};
    snprintf(title, sizeof title, "Error and pixels of a drop");
    btg_chart_panel panel =
        btg_chart_panel_of(title, "log10 of the pixels of a drop", "log10 of the error, mm");
    btg_chart_add(&panel, BTG_CHART_LINE, 0, "one level", c->x[0], c->y[0], CURVE);
    btg_chart_add(&panel, BTG_CHART_LINE, 1, "two levels", c->x[1], c->y[1], CURVE);
    btg_chart_add(&panel, BTG_CHART_DASHES, 4, "pixels' share of the tolerance", x, y, 2);
    snprintf(title, sizeof title, "Plan for %g mm", o->solver.tolerance_mm);
    return btg_chart_write(path, title, &panel, 1, 1, message);
}

int app_plan(int count, char **list) {
    words w = {.count = count, .list = list};
    btg_tool tool;
    btg_part *part = NULL;
    btg_message message;
    plan p;
    curve c;
    options_default(&w.path);
    if (!parse(&w)) return APP_UNUSABLE;
    if (w.path.help) return app_help("plan");
    btg_status status = btg_tool_init(&w.path.tool, &tool, &message);
    if (status == BTG_OK && !(w.path.tool.minor_radius_mm > 0))
        return app_complain(APP_UNUSABLE, "--tool: the model needs a minor radius above 0");
    if (status == BTG_OK) status = btg_gltf_load(w.path.part, &w.path.gltf, &part, &message);
    if (status != BTG_OK) return app_complain(app_code(status), "%s", message.text);
    plan_part look = plan_look(part);
    status = plan_make(&tool, &look, w.path.solver.tolerance_mm, &p, &message);
    if (status == BTG_OK) {
        trade(&tool, &p, &c);
        status = settle(&w.path, part, &tool, &p, &message);
    }
    if (status == BTG_OK && w.picture) status = draw(&p, &w.path, &c, w.picture, &message);
    btg_part_destroy(part);
    if (status == BTG_ERROR_ARGUMENT) return app_complain(APP_UNUSABLE, "%s", message.text);
    if (status != BTG_OK) return app_complain(APP_FAILED, "%s", message.text);
    btg_output out = btg_output_borrow(stdout);
    if (w.path.json)
        print_json(&p, &w.path, &c, &out);
    else if (!w.path.quiet)
        print_plan(&p, &w.path, out.file);
    status = btg_output_finish(&out, &message);
    if (status != BTG_OK) return app_complain(APP_FAILED, "%s", message.text);
    return holds(&p) ? APP_DONE : APP_FAILED;
}
