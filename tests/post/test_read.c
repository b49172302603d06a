/* Programs read back: every position of the path is passed, the poses told keep to the machine's
 * own motion, and what is not understood is refused. */
#include "../conformance/rng.h"
#include "listing.h"
#include "post/read.h"

#define ERROR_MM 2e-4
#define REACH_MM 20.0
#define WAYS     400
#define DAMAGED  4000
#define PATH_MM  6e-3 /* off the path by tolerance at the tip, and by 20 / 12.7 of it at the rim */
#define POSES    200  /* of a damaged program's line that are looked at */

static btg_machine machine_of(const char *name, int tcp, int vectors) {
    btg_machine_def d = btg_machine_def_default();
    btg_machine m = {.def = d};
    CHECK(btg_machine_find(name, &d) == BTG_OK);
    d.tcp = tcp;
    d.vectors = vectors;
    d.inverse_time = d.inverse_time || !tcp;
    d.part_origin = vec(-70, -60, 5);
    CHECK(btg_machine_init(&d, &m, NULL) == BTG_OK);
    return m;
}

/* ---- whole programs ------------------------------------------------------------------------ */

static btg_position wave(int i) {
    double x = 20.0 * (i / 20), y = 6.0 * (i % 20);
    return pose(x, y, 10 + 3 * sin(x / 9) * cos(y / 7), 12 + 11 * sin(y / 6 + x), 7 * y + x);
}

static void write_program(listing *l, const btg_machine *m) {
    btg_tool tool = listing_tool();
    btg_program_def def = listing_def(l);
    btg_program *p = NULL;
    l->size = 0;
    CHECK(btg_program_create(&def, m, &tool, &p, NULL) == BTG_OK);
    for (int i = 0; i < 60; i++) {
        btg_position at = wave(i);
        CHECK(btg_program_add(p, &at, i % 20 > 0, &l->message) == BTG_OK);
    }
    CHECK(btg_program_end(p, &l->info, &l->message) == BTG_OK);
    btg_program_destroy(p);
}

typedef struct answer {
    btg_status status;
    btg_message message;
    bool whole;                   /* the program is not damaged: it is looked at closely */
    int line, poses, nearest[60]; /* of 60 positions: how often each is passed */
    double worst;
    double began, most, stray; /* off the path: last line's end, this line so far, all of those that
                                  begin and end on it */
    btg_reader reader;
} answer;

/* How far a pose is from where tip and axis are to go between two positions. */
static double off_path(const btg_reader_place *p) {
    double least = INFINITY;
    for (int i = 0; i < 59; i++) {
        btg_position a = wave(i), b = wave(i + 1);
        btg_vec3 way = vec_sub(b.tip, a.tip);
        double part = vec_dot(vec_sub(p->tip, a.tip), way) / vec_norm2(way);
        if (i % 20 == 19 || part < -1e-3 || part > 1.001) continue;
        double tip = vec_norm(vec_sub(p->tip, vec_mad(a.tip, way, part)));
        double axis = vec_norm(vec_sub(p->axis, vec_turned(a.axis, b.axis, part)));
        least = fmin(least, tip + REACH_MM * axis);
    }
    return least;
}

static void look_between(answer *a, const btg_reader_place *p) {
    double off = off_path(p);
    a->most = fmax(a->most, off);
    if (p->between) return;
    if (a->began < PATH_MM && off < PATH_MM && a->reader.motion == 1)
        a->stray = fmax(a->stray, a->most);
    a->began = off;
    a->most = 0;
}

static void look(answer *a, const btg_reader_place *p) {
    a->poses++;
    CHECK(vec_finite(p->tip) && fabs(vec_norm(p->axis) - 1) < 1e-9);
    if (a->whole) look_between(a, p);
    for (int i = 0; i < 60; i++) {
        btg_position want = wave(i);
        double off = vec_norm(vec_sub(p->tip, want.tip));
        off += REACH_MM * vec_norm(vec_sub(p->axis, want.axis));
        if (off > 5e-3 || p->between) continue;
        a->nearest[i]++;
        a->worst = fmax(a->worst, off);
    }
}

static answer read_text(const btg_machine *m, const char *text, bool whole) {
    answer a = {.whole = whole, .began = INFINITY};
    btg_reader_open(&a.reader, m, ERROR_MM, REACH_MM);
    while (*text && a.status >= 0) {
        char line[256];
        size_t size = strcspn(text, "\n");
        snprintf(line, sizeof line, "%.*s", (int)size, text);
        text += size + (text[size] != '\0');
        a.line++;
        a.status = btg_reader_line(&a.reader, line, &a.message);
        btg_reader_place p;
        bool any = true;
        for (int i = 0; a.status >= 0 && any && (whole || i < POSES); i++) {
            a.status = btg_reader_pose(&a.reader, &p, &any, &a.message);
            if (a.status >= 0 && any) look(&a, &p);
        }
    }
    return a;
}

static const struct {
    const char *name;
    int tcp, vectors;
} controls[] = {{"xyzac-trt", 1, 0}, {"xyzbc-trt", 1, 0},  {"xyzac-trt", 0, 0}, {"fanuc", 1, 0},
                {"fanuc", 1, 1},     {"fanuc", 0, 0},      {"siemens", 1, 0},   {"siemens", 1, 1},
                {"siemens", 0, 0},   {"heidenhain", 1, 0}, {"heidenhain", 0, 0}};
#define CONTROLS (sizeof controls / sizeof *controls)

static void test_round_trip(listing *l) {
    for (size_t k = 0; k < CONTROLS; k++) {
        btg_machine m = machine_of(controls[k].name, controls[k].tcp, controls[k].vectors);
        write_program(l, &m);
        answer a = read_text(&m, l->text, true);
        if (a.status < 0) printf("%s line %d: %s\n", controls[k].name, a.line, a.message.text);
        CHECK(a.status == BTG_OK && a.reader.ended);
        CHECK(a.reader.promised[0] == (long)a.reader.moves && a.reader.moves == l->info.blocks);
        CHECK(a.reader.promised[1] == (long)a.reader.blocks);
        int missed = 0;
        for (int i = 0; i < 60; i++)
            if (a.nearest[i] == 0) {
                missed++;
                printf("%s %d %d: position %d missed\n", controls[k].name, controls[k].tcp,
                       controls[k].vectors, i);
            }
        CHECK(missed == 0);
        CHECK(a.reader.haste <= 1.01);
        CHECK(controls[k].vectors || !controls[k].tcp || a.reader.haste > 0.5);
        printf("%s tcp %d vectors %d: %d poses, positions within %.2g mm, between them %.2g mm, "
               "joints at %.3f\n",
               controls[k].name, controls[k].tcp, controls[k].vectors, a.poses, a.worst, a.stray,
               a.reader.haste);
        CHECK(a.worst < 2.5e-3 && a.stray < PATH_MM && a.stray > 0);
    }
}

/* ---- motion -------------------------------------------------------------------------------- */

static double off_chord(const btg_machine *m, const btg_way *w, double from, double to) {
    btg_way_pose a, b, at;
    double most = 0;
    btg_way_at(m, w, from, &a);
    btg_way_at(m, w, to, &b);
    for (int k = 1; k < 40; k++) {
        double part = k / 40.0;
        btg_way_at(m, w, from + (to - from) * part, &at);
        btg_vec3 tip = vec_mad(a.tip, vec_sub(b.tip, a.tip), part);
        most =
            fmax(most, vec_norm(vec_sub(at.tip, tip)) +
                           REACH_MM * vec_norm(vec_sub(at.axis, vec_turned(a.axis, b.axis, part))));
    }
    return most;
}

/* Poses told of any motion, long turns included: between them the tool is where they say. */
static void test_motion(void) {
    rng random = rng_of(7, "read", 0);
    double worst = 0;
    for (int i = 0; i < WAYS; i++) {
        btg_machine m = machine_of(controls[i % CONTROLS].name, 1, 0);
        btg_way w = {.kind = i % 2 ? BTG_WAY_TCP : BTG_WAY_JOINTS};
        for (int j = 0; j < 2; j++) {
            w.angle_from[j] = rng_range(&random, -1.5, 1.5);
            double turn = i % 3 ? 0.2 : 3;
            w.angle_to[j] = w.angle_from[j] + rng_range(&random, -turn, turn);
        }
        double x = rng_range(&random, -50, 50), y = rng_range(&random, -50, 50);
        w.to = vec(x, y, 3);
        int pieces = 0;
        for (double at = 0, step = 1; at < 1; pieces++) {
            double next = btg_way_piece(&m, &w, at, 2 * step, ERROR_MM, REACH_MM);
            worst = fmax(worst, off_chord(&m, &w, at, next));
            CHECK(next > at && next <= 1);
            step = next - at;
            at = next;
        }
        CHECK(pieces < 20000);
    }
    printf("motion: told to %.3g mm of %.3g\n", worst, ERROR_MM);
    CHECK(worst <= ERROR_MM && worst > 0.5 * ERROR_MM);
}

/* ---- what is refused ----------------------------------------------------------------------- */

static void refused(const char *name, int vectors, const char *text, int line, const char *say) {
    btg_machine m = machine_of(name, 1, vectors);
    answer a = read_text(&m, text, false);
    if (a.status >= 0 || a.line != line || !strstr(a.message.text, say))
        printf("%s '%s': line %d: %s\n", name, text, a.line, a.status < 0 ? a.message.text : "ok");
    CHECK(a.status < 0 && a.line == line && strstr(a.message.text, say));
}

static void test_refusals(void) {
    static const char *const words[][2] = {
        {"G91", "'G91'"},          {"G2 X1 Y1 I1 J0", "'G2'"}, {"G20", "'G20'"},
        {"X1e3", "'E': no"},       {"X1.2.3", "'.3'"},         {"X", "'X'"},
        {"G1 X1 X2", "twice"},     {"X--1", "'X--1'"},         {"X1234567890123456", "'X1234"},
        {"X999999999", "'X9999"},  {"#1=2", "'#1=2'"},         {"G1 U1 F1", "'U'"},
        {"X[1+2]", "'X[1+2]'"},    {"G0 A1 B1", "'B'"},        {"(open", "does not end"},
        {"G43.4 H1", "Fanuc"},     {"G43 H2", "H is not"},     {"M98 P1", "'M98'"},
        {"G1 X1 F0", "F is not"},  {"G1 X1 F-5", "F is not"},  {"TRAORI", "'TRAORI'"},
        {"G1 X1", "no F"},         {"G1.23 X1", "'G1.23'"},    {"/G1 X1 F1", "'/G1'"},
        {"G0 X2000000", "beyond"}, {"G0 A500", "joint A"},     {"G0 X9000", "joint X"},
        {"G1 I0 J0 K1 F9", "'I'"}, {"L X1", "no decimal"},     {"M30 M30\nG0 X1", "after the"},
    };
    for (size_t i = 0; i < sizeof words / sizeof *words; i++) {
        char text[256];
        snprintf(text, sizeof text, "G43 T1 H1\nG93\nG0 X1 Y2 Z3\n%s\n", words[i][0]);
        refused("xyzac-trt", 0, text, strchr(words[i][0], '\n') ? 5 : 4, words[i][1]);
    }
    refused("xyzac-trt", 0, "X1\n", 1, "before G0");
    refused("xyzac-trt", 0, "G0 X1\n", 1, "tool's length");
    refused("xyzac-trt", 0, "G43 H1\nG1 X1 F9\n", 2, "where the machine stands");
    refused("fanuc", 0, "G43.4 H1\nG53 G0 Z1\n", 2, "machine coordinates");
    refused("fanuc", 1, "G0 A0 C0\nG43.5 H1\nG0 X0 Y0 Z0 I0 J0\n", 3, "not whole");
    refused("fanuc", 1, "G0 A0 C0\nG43.5 H1\nG0 X0 Y0 Z0 I0 J0 K2\n", 3, "not whole");
    refused("fanuc", 1, "G0 A0 C0\nG43.5 H1\nG0 X0 A0\n", 3, "an angle");
    refused("siemens", 1, "G54 D1\nTRAORI\nG0 X0 A3=0 B3=0 C3=1\n", 3, "without ORIVECT");
    refused("siemens", 1, "ORIVECT\n", 1, "without TRAORI");
    refused("siemens", 1, "G500\n", 1, "'G500'");
    refused("siemens", 1, "CYCLE832\n", 1, "'CYCLE'");
    refused("heidenhain", 0, "0 BEGIN PGM A INCH\n", 1, "MM");
    refused("heidenhain", 0, "0 BEGIN PGM A MM\n1 CC X1 Y1\n", 2, "'CC'");
    refused("heidenhain", 0, "0 BEGIN PGM A MM\n1 L IX+1 FMAX\n", 2, "'IX'");
    refused("heidenhain", 0, "0 TOOL CALL 1 Z\n1 L X+1 FMAX\n", 2, "BEGIN PGM");
    refused("heidenhain", 0, "0 BEGIN PGM A MM\n1 TOOL CALL 1 X\n", 2, "axis is not Z");
}

/* ---- damage -------------------------------------------------------------------------------- */

static size_t damage(rng *random, char *text, size_t size, size_t room) {
    static const char spice[] = "GXYZABCFMIJKHLRT0123456789.-+=()[]#;%/ \t\n\"\\eE";
    size_t at = (size_t)(rng_range(random, 0, 1) * (double)size);
    size_t run = 1 + (size_t)(rng_range(random, 0, 1) * 12);
    if (at + run > size) run = size - at;
    double what = rng_range(random, 0, 1);
    if (what < 0.25) {
        memmove(text + at, text + at + run, size - at - run);
        return size - run;
    }
    if (what < 0.5 && size + run < room) {
        memmove(text + at + run, text + at, size - at);
        return size + run;
    }
    for (size_t i = at; i < at + run; i++) {
        double choice = rng_range(random, 0, 1);
        double other = rng_range(random, 0, 1);
        text[i] = choice < 0.9 ? spice[(size_t)(other * (sizeof spice - 1))]
                               : (char)(1 + (int)(other * 254));
    }
    return size;
}

/* Whatever the bytes: an answer, finite poses, and a reason where there is none. */
static void test_damage(listing *l) {
    rng random = rng_of(11, "read", 0);
    int refusals = 0, rounds = getenv("BTG_TEST_QUICK") ? DAMAGED / 8 : DAMAGED;
    for (int i = 0; i < rounds; i++) {
        const size_t k = (size_t)i % CONTROLS;
        btg_machine m = machine_of(controls[k].name, controls[k].tcp, controls[k].vectors);
        if (i < (int)CONTROLS || i % 64 == 0) write_program(l, &m);
        char text[1600];
        size_t from = (size_t)rng_pick(&random, 3) / 2 * (size_t)rng_pick(&random, 1000);
        size_t size = sizeof text - 400;
        memcpy(text, l->text + from, size);
        for (int n = 1 + (int)(rng_range(&random, 0, 1) * 4); n > 0; n--)
            size = damage(&random, text, size, sizeof text - 1);
        text[size] = '\0';
        answer a = read_text(&m, text, false);
        CHECK(a.status == BTG_OK || a.message.text[0] != '\0');
        refusals += a.status < 0;
    }
    printf("%d of %d damaged programs refused\n", refusals, rounds);
    CHECK(refusals > rounds / 4 && refusals < rounds);
}

int main(void) {
    listing *l = calloc(1, sizeof *l);
    if (!l) return 1;
    test_round_trip(l);
    test_motion();
    test_refusals();
    test_damage(l);
    free(l);
    return check_result();
}
