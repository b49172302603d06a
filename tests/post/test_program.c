/* Programs: the way the rotary joints take, limits, the pole, linearisation, feeds, and text. */
#include "../conformance/rng.h"
#include "listing.h"

#include <ctype.h>

static listing *l;
static btg_position path[20000];

static btg_machine_def machine(const char *name) {
    btg_machine_def d = btg_machine_def_default();
    CHECK(btg_machine_find(name, &d) == BTG_OK);
    return d;
}

static void run(const btg_machine_def *d, int count) {
    btg_program_def def = listing_def(l);
    listing_run(l, d, &def, path, count, -1);
    if (l->status != BTG_OK) fprintf(stderr, "%s: %s\n", d->name, l->message.text);
    CHECK(l->status == BTG_OK);
}

#define STEP_MM 0.1

/* The tool leans by `lean` and its lean turns from one angle to another, in steps of one degree. */
static int turning(double lean, int from, int to) {
    int n = 0, step = from < to ? 1 : -1;
    for (int a = from; a != to + step; a += step, n++)
        path[n] = pose(STEP_MM * n, 20, 10, lean, a);
    return n;
}

/* Largest step of a rotary joint from one cutting block to the next. */
static double largest_step(int joint) {
    double most = 0;
    for (int i = 1; i < l->count; i++) {
        if (l->blocks[i].rapid || l->blocks[i - 1].rapid) continue;
        most = fmax(most, fabs(l->blocks[i].word[3 + joint] - l->blocks[i - 1].word[3 + joint]));
    }
    return most;
}

/* Smallest and largest angle of a joint over the blocks that cut at the height of the path. */
static void range_of(int joint, double *low, double *high) {
    *low = INFINITY;
    *high = -INFINITY;
    for (int i = 0; i < l->count; i++) {
        if (l->blocks[i].word[2] > 10.5) continue;
        *low = fmin(*low, l->blocks[i].word[3 + joint]);
        *high = fmax(*high, l->blocks[i].word[3 + joint]);
    }
}

/* ---- the way of the rotary joints ---------------------------------------------------------- */

static void test_wind_up(void) {
    btg_machine_def d = machine("fanuc");
    double low, high;
    run(&d, turning(10, -300, 700));
    CHECK(l->info.rewinds == 0 && l->info.gaps == 0 && l->info.retracts == 0);
    CHECK(largest_step(1) < 1.1);
    range_of(1, &low, &high);
    CHECK_NEAR(high - low, 1000, 1e-3);
}

/* Limits that leave room for the turn, if it starts in the right place. */
static void test_start_in_the_right_turn(void) {
    btg_machine_def d = machine("fanuc");
    double low, high;
    d.rotary[1].min_rad = RADIANS(-330);
    d.rotary[1].max_rad = RADIANS(330);
    for (int start = -360; start <= 360; start += 45) {
        run(&d, turning(10, start, start + 290));
        CHECK(l->info.rewinds == 0 && l->info.retracts == 0);
        range_of(1, &low, &high);
        CHECK(low >= -330 && high <= 330);
        CHECK_NEAR(high - low, 290, 1e-3);
        run(&d, turning(10, start + 290, start));
        CHECK(l->info.rewinds == 0);
    }
}

static void test_rewind(void) {
    btg_machine_def d = machine("fanuc");
    double low, high;
    d.rotary[1].min_rad = RADIANS(-330);
    d.rotary[1].max_rad = RADIANS(330);
    int n = turning(10, 0, 1400);
    run(&d, n);
    /* 1400 degrees in pieces of 660 at most. */
    CHECK(l->info.rewinds == 2 && l->info.retracts == 2 && l->info.gaps == 0);
    range_of(1, &low, &high);
    CHECK(low >= -330 && high <= 330);
    /* Nothing is left uncut: every position is a block, those of the rewinds twice. */
    int at[1401] = {0};
    for (int i = 0; i < l->count; i++) {
        double k = l->blocks[i].word[0] / STEP_MM;
        if (l->blocks[i].word[2] < 10 + 1e-6) at[(int)lround(k)]++;
    }
    int twice = 0;
    for (int i = 0; i < n; i++) {
        CHECK(at[i] > 0);
        if (at[i] > 1) twice++;
    }
    CHECK(twice == 2);
    /* Joints turn only over the part while it rewinds. */
    for (int i = 1; i < l->count; i++) {
        double turn = fabs(l->blocks[i].word[4] - l->blocks[i - 1].word[4]);
        if (turn > 20) CHECK(l->blocks[i].word[2] >= 50 && l->blocks[i - 1].word[2] >= 50);
    }
}

/* Limits of one turn: no angle is in two turns but the limit itself, so the tool is lifted there,
 * between two positions, and nothing stays uncut. Less than a turn leaves a gap, and says so. */
static void test_one_turn_alone(void) {
    btg_machine_def d = machine("fanuc");
    d.rotary[0].min_rad = 0;
    for (int limit = 180; limit >= 179; limit--) {
        d.rotary[1].min_rad = RADIANS(-limit);
        d.rotary[1].max_rad = RADIANS(limit);
        /* Steps that do not meet the limit. */
        int n = 0;
        for (double a = 0.3; a < 365; a += 7, n++)
            path[n] = pose(n, 20, 10, 10, a);
        run(&d, n);
        CHECK(l->info.rewinds == 1 && l->info.retracts == 1);
        CHECK(l->info.gaps == (limit < 180));
        CHECK(largest_step(1) < 7.1);
        double end = NAN, begin = NAN;
        for (int i = 1; i < l->count; i++) {
            if (fabs(l->blocks[i].word[2] - 10) > 1e-3 || fabs(l->blocks[i].word[0]) < 1e-3)
                continue;
            double c = l->blocks[i].word[4];
            if (fabs(fabs(c) - limit) > 1e-3) continue;
            if (isnan(end)) end = l->blocks[i].word[0];
            begin = l->blocks[i].word[0];
        }
        CHECK_NEAR(begin - end, limit < 180 ? 2 / 7.0 : 0, 1e-2);
    }
}

/* Next to the pole a whole turn would hardly show at the tool; the joints make it over the part. */
static void test_no_whole_turn(void) {
    btg_machine_def d = machine("fanuc");
    d.rotary[1].min_rad = RADIANS(-180);
    d.rotary[1].max_rad = RADIANS(180);
    d.rotary[0].min_rad = 0;
    run(&d, turning(0.012, 0, 365));
    CHECK(l->info.rewinds >= 1 && largest_step(1) <= 181);
}

/* Whatever the joints do on a way over the part, the tool leans and stays above clear_z. */
static void test_clearance(void) {
    btg_machine_def d = machine("siemens");
    btg_machine m = {.def = d};
    btg_tool tool = listing_tool();
    rng r = rng_of(3, "clearance", 0);
    int n = 0;
    d.vectors = 0;
    d.rotary[0].min_rad = d.rotary[1].min_rad = -INFINITY;
    d.rotary[0].max_rad = d.rotary[1].max_rad = INFINITY;
    d.rotary[1].direction = vec(0, 1, 1);
    CHECK(btg_machine_init(&d, &m, NULL) == BTG_OK);
    for (int i = 0; i < 400; i++) {
        path[n++] = pose(i, 0, 10, rng_range(&r, 40, 85), rng_range(&r, -180, 180));
        path[n++] = (btg_position){.status = BTG_NO_CONTACT};
    }
    run(&d, n);
    CHECK(l->info.retracts == 399);
    double lowest = INFINITY;
    for (int i = 3; i < l->count; i++) {
        const block *a = &l->blocks[i - 1], *b = &l->blocks[i];
        if (a->word[3] == b->word[3] && a->word[4] == b->word[4]) continue;
        for (int k = 0; k <= 64; k++) {
            double word[5];
            btg_vec3 tip, axis;
            for (int j = 0; j < 5; j++)
                word[j] = a->word[j] + (b->word[j] - a->word[j]) * k / 64.0;
            listing_pose(&m, word, &tip, &axis);
            lowest = fmin(lowest, 50 + tip.z - btg_post_lift_z(&tool, axis, 50));
        }
    }
    /* Between the places where the post looks, a little. */
    CHECK(lowest > 50 - 0.1);
}

static void test_solutions(void) {
    btg_machine_def d = machine("fanuc");
    double low, high;
    for (int side = -1; side <= 1; side += 2) {
        d.rotary[0].min_rad = RADIANS(side < 0 ? -100 : -3);
        d.rotary[0].max_rad = RADIANS(side < 0 ? 3 : 100);
        run(&d, turning(10, 0, 200));
        range_of(0, &low, &high);
        CHECK_NEAR(low, 10.0 * side, 1e-3);
        CHECK_NEAR(high, 10.0 * side, 1e-3);
        CHECK(l->info.rewinds == 0);
    }
}

/* From one side through the pole to the other: A goes through 0, C stays. */
static void test_through_the_pole(void) {
    static const char *const name[3] = {"xyzac-trt", "heidenhain", "fanuc"};
    for (int k = 0; k < 3; k++) {
        btg_machine_def d = machine(name[k]);
        double low, high;
        int n = 0;
        d.control = BTG_CONTROL_FANUC;
        for (int i = -40; i <= 40; i++)
            path[n++] = pose(i, 0, 10, i / 4.0, 30);
        run(&d, n);
        int c = d.rotary[0].letter == 'C' ? 0 : 1;
        range_of(c, &low, &high);
        CHECK(high - low < 1e-3);
        range_of(1 - c, &low, &high);
        CHECK_NEAR(high - low, 20, 1e-3);
        CHECK(l->info.rewinds == 0 && l->info.retracts == 0);
    }
}

/* On the pole C waits, and turns evenly to where it is needed next. */
static void test_on_the_pole(void) {
    btg_machine_def d = machine("fanuc");
    int n = 0;
    for (int i = 0; i < 39; i++, n++) {
        double lean = i < 10 ? 0 : i < 20 ? 5 : i < 29 ? 1e-9 : 5;
        path[n] = pose(i, 0, 10, lean, i < 20 ? 60 : i < 29 ? 77 * i : 110);
    }
    run(&d, n);
    CHECK(largest_step(1) < 5.1);
    CHECK(l->info.rewinds == 0);
    double low, high;
    range_of(1, &low, &high);
    CHECK_NEAR(high - low, 50, 1e-3);
}

/* A control that is given vectors turns the joints itself: no rewinds, no points between. */
static void test_vectors(void) {
    btg_machine_def d = machine("siemens");
    run(&d, turning(10, 0, 1000));
    CHECK(l->info.rewinds == 0 && l->info.retracts == 0 && l->info.inserted == 0);
    CHECK(l->info.blocks < 1010);
}

/* However it is cut into windows, every position comes out once and in order. */
static void test_windows(void) {
    static const size_t window[4] = {2, 3, 17, 1000};
    btg_machine_def d = machine("fanuc");
    btg_program_def def = listing_def(l);
    int n = turning(10, 0, 500);
    for (int k = 0; k < 4; k++) {
        def.window = window[k];
        listing_run(l, &d, &def, path, n, 100);
        CHECK(l->status == BTG_OK && l->info.positions == (uint64_t)n);
        CHECK(l->info.retracts == 1 && l->info.rewinds == 0);
        CHECK(largest_step(1) < 1.1);
    }
}

/* ---- limits --------------------------------------------------------------------------------- */

static void expect_refusal(const btg_machine_def *d, int count, const char *say) {
    btg_program_def def = listing_def(l);
    l->message.text[0] = '\0';
    listing_run(l, d, &def, path, count, -1);
    bool said = strstr(l->message.text, say) != NULL;
    if (!said) fprintf(stderr, "wanted '%s', got '%s'\n", say, l->message.text);
    CHECK(l->status == BTG_ERROR_UNSUPPORTED && said);
}

static void test_out_of_reach(void) {
    btg_machine_def d = machine("fanuc");
    path[0] = pose(0, 0, 10, 0, 0);
    path[1] = pose(1, 0, 10, 40, 0);
    d.rotary[0].min_rad = RADIANS(-30);
    d.rotary[0].max_rad = RADIANS(30);
    expect_refusal(
        &d, 2,
        "joint A at 40.000 degrees (limits -30.000 to 30.000) or joint A at -40.000 degrees");
    path[1] = pose(600, 0, 10, 0, 0);
    expect_refusal(&d, 2, "joint X at 600.000 mm (limits -500.000 to 500.000)");
    /* Both ends are within reach, the way from one to the other is not. */
    d = machine("fanuc");
    d.linear[0].min_mm = d.linear[1].min_mm = -410;
    d.linear[0].max_mm = d.linear[1].max_mm = 410;
    path[0] = pose(300, 300, 10, 10, 90);
    path[1] = pose(300, 300, 10, 10, 0);
    expect_refusal(&d, 2, "the way needs joint");
}

static void test_statuses(void) {
    btg_machine_def d = machine("fanuc");
    int n = 0;
    for (int i = 0; i < 5; i++)
        path[n++] = pose(i, 0, 10, 5, 0);
    path[2].status = BTG_NO_CONTACT;
    path[2].tip = vec_nan();
    run(&d, n);
    CHECK(l->info.positions == 4 && l->info.retracts == 1);
    path[1].tip.x = NAN;
    btg_program_def def = listing_def(l);
    listing_run(l, &d, &def, path, n, -1);
    CHECK(l->status == BTG_ERROR_ARGUMENT);
    /* Nothing to cut: still a program. */
    path[0].status = BTG_NO_CONTACT;
    run(&d, 1);
    CHECK(strstr(l->text, "M30") != NULL && l->count == 0);
}

/* ---- linearisation and feeds ---------------------------------------------------------------- */

/* A path that turns a lot between its positions. */
static int swinging(void) {
    int n = 0;
    for (int i = 0; i <= 20; i++) {
        double s = i / 20.0;
        path[n++] = pose(120 * s - 60, 30 * sin(9 * s), 10 + 5 * cos(7 * s), 8 + 15 * s, 260 * s);
    }
    return n;
}

static double from_segment(btg_vec3 a, btg_vec3 b, btg_vec3 p) {
    btg_vec3 way = vec_sub(b, a), arm = vec_sub(p, a);
    double part = fmin(fmax(vec_dot(arm, way) / fmax(vec_norm2(way), 1e-30), 0), 1);
    return vec_norm(vec_mad(arm, way, -part));
}

/* The machine moves its joints evenly from block to block: the tip stays on the path's straight
 * pieces, the axis between those of the two positions, within the tolerance and the rounding. */
static void check_motion(const btg_machine *m, int positions) {
    double tip_off = 0, axis_off = 0, word[5];
    int at = -1;                                               /* the position before */
    for (int i = 3; i < l->count && at + 1 < positions; i++) { /* from where all words are known */
        const block *a = &l->blocks[i - 1], *b = &l->blocks[i];
        btg_vec3 tip, axis;
        listing_pose(m, b->word, &tip, &axis);
        for (int k = 1; k <= 20 && at >= 0; k++) {
            btg_vec3 on, lean, from = path[at].tip, to = path[at + 1].tip;
            for (int j = 0; j < 5; j++)
                word[j] = a->word[j] + (b->word[j] - a->word[j]) * k / 20.0;
            listing_pose(m, word, &on, &lean);
            double s = vec_norm(vec_sub(on, from)) / vec_norm(vec_sub(to, from));
            btg_vec3 wanted =
                vec_unit(vec_add(vec_scale(path[at].axis, 1 - s), vec_scale(path[at + 1].axis, s)));
            tip_off = fmax(tip_off, from_segment(from, to, on));
            axis_off = fmax(axis_off, vec_norm(vec_sub(lean, wanted)));
        }
        if (vec_norm(vec_sub(tip, path[at + 1].tip)) < 1e-3) at++;
    }
    CHECK(at == positions - 1);
    CHECK(tip_off < 0.002 * 1.3);
    CHECK(axis_off * 12.7 < 0.002 * 1.3);
}

static void test_linearisation(void) {
    static const char *const name[4] = {"xyzac-trt", "fanuc", "siemens", "heidenhain"};
    for (int k = 0; k < 8; k++) {
        btg_machine_def d = machine(name[k % 4]);
        btg_machine m = {.def = d};
        d.control = BTG_CONTROL_LINUXCNC;
        d.vectors = 0;
        d.tcp = k >= 4;
        d.inverse_time = 1;
        d.rotary[0].pivot = d.rotary[0].in_head ? vec(0, 0, 40) : vec(10, 20, -30);
        d.part_origin = vec(20, -30, 5);
        CHECK(btg_machine_init(&d, &m, NULL) == BTG_OK);
        int n = swinging();
        run(&d, n);
        CHECK(l->info.inserted > 50);
        check_motion(&m, n);
    }
}

/* Joints from block to block, from the words alone. */
static void joints_of(const btg_machine *m, const block *b, double joint[5]) {
    btg_vec3 tip, axis;
    listing_pose(m, b->word, &tip, &axis);
    btg_joints q[2];
    CHECK(btg_machine_inverse(m, tip, axis, q) == BTG_OK);
    bool first = fabs(remainder(q[0].rotary_rad[0] - RADIANS(b->word[3]), 2 * BTG_PI)) < 1e-3 &&
                 fabs(remainder(q[0].rotary_rad[1] - RADIANS(b->word[4]), 2 * BTG_PI)) < 1e-3;
    memcpy(joint, q[first ? 0 : 1].linear_mm, 3 * sizeof *joint);
    joint[3] = RADIANS(b->word[3]);
    joint[4] = RADIANS(b->word[4]);
}

static void test_speeds(void) {
    btg_machine_def d = machine("xyzac-trt");
    btg_machine m = {.def = d};
    btg_program_def def = listing_def(l);
    def.feed_mm_per_min = 20000;
    for (int i = 0; i < 3; i++)
        d.linear[i] = (btg_linear_def){-500, 500, 50, 400};
    CHECK(btg_machine_init(&d, &m, NULL) == BTG_OK);
    int n = swinging();
    listing_run(l, &d, &def, path, n, -1);
    CHECK(l->status == BTG_OK && l->info.slowed > 50);
    double fastest = 0, before[5] = {0}, speed_before[5] = {0}, time_before = 0, hardest = 0;
    for (int i = 0; i < l->count; i++) {
        double joint[5];
        const block *b = &l->blocks[i];
        bool cutting = !b->rapid && b->word[2] < 15.01;
        if (i > 2) joints_of(&m, b, joint);
        for (int j = 0; j < 5 && i > 2; j++) {
            double top = j < 3 ? d.linear[j].speed_mm_per_s : d.rotary[j - 3].speed_rad_per_s;
            double most = j < 3 ? d.linear[j].acceleration_mm_per_s2
                                : d.rotary[j - 3].acceleration_rad_per_s2;
            double time = 60 / b->feed, speed = (joint[j] - before[j]) / time;
            if (cutting) fastest = fmax(fastest, fabs(speed) / top);
            if (cutting && time_before > 0) {
                double change = fabs(speed - speed_before[j]) / ((time + time_before) / 2);
                hardest = fmax(hardest, change / most);
            }
            speed_before[j] = speed;
        }
        time_before = cutting && i > 2 ? 60 / b->feed : 0;
        memcpy(before, joint, sizeof before);
    }
    /* Full speed is used somewhere; words are rounded to 1e-3 degrees and 1e-4 mm. */
    CHECK(fastest <= 1.01 && fastest > 0.5);
    CHECK(hardest <= 1.1 && hardest > 0.5);
}

/* In mm per minute the tip's feed is what was asked wherever joints allow it. */
static void test_feed(void) {
    btg_machine_def d = machine("fanuc");
    int n = 0;
    for (int i = 0; i < 20; i++)
        path[n++] = pose(i, 0, 10, 5, 0);
    run(&d, n);
    CHECK(l->info.slowed == 0);
    CHECK(strstr(l->text, "F1000.0\n") != NULL);
    int words = 0;
    for (const char *s = l->text; (s = strstr(s, " F")) != NULL; s++)
        words++;
    CHECK(words == 1);
}

/* ---- text ----------------------------------------------------------------------------------- */

/* [+-] digits . digits, and no other way to write a number. */
static void check_words(void) {
    for (const char *s = l->text; *s; s += strcspn(s, "\n") + 1) {
        size_t size = strcspn(s, "\n");
        CHECK(size < 200);
        if (*s == '(' || *s == ';' || strstr(s, "PGM") == s + 2) continue;
        for (size_t i = 0; i + 1 < size; i++) {
            bool number = strchr("XYZABCIJKF", s[i]) && strchr("+-.0123456789", s[i + 1]);
            if (!number) continue;
            size_t k = i + 1 + (s[i + 1] == '-' || s[i + 1] == '+'), digits = k;
            while (isdigit((unsigned char)s[k]))
                k++;
            if (s[k] == '=') continue; /* the name A3 */
            CHECK(k > digits && s[k] == '.' && isdigit((unsigned char)s[k + 1]));
            for (k++; isdigit((unsigned char)s[k]);)
                k++;
            CHECK(k == size || s[k] == ' ');
        }
    }
}

static void test_numbers(void) {
    static const double odd[8] = {0, 1e-5, -1e-5, 1e-9, -0.00049, 0.1, -123.456789, 99.99996};
    btg_machine_def d;
    for (size_t k = 0; btg_machine_at(k, &d) == BTG_OK; k++) {
        int n = 0;
        for (int i = 0; i < 64; i++)
            path[n++] = pose(odd[i % 8], odd[i / 8] + 1e-4 * i, 10 + odd[i % 7], 1e-7 * i * i, i);
        run(&d, n);
        check_words();
        CHECK(!strstr(l->text, "-0.0 ") && !strstr(l->text, "-0.0\n"));
    }
}

static void test_write_fails(void) {
    btg_machine_def d = machine("xyzac-trt");
    btg_program_def def = listing_def(l);
    int n = 0;
    for (int i = 0; i < 20000; i++)
        path[n++] = pose(i * 0.01, 0, 10, 5, 0.001 * i);
    l->room = 100000;
    listing_run(l, &d, &def, path, n, -1);
    CHECK(l->status == BTG_ERROR_FILE);
}

static void test_definitions(void) {
    btg_machine_def d = machine("fanuc");
    btg_program_def def = listing_def(l);
#define REFUSE(change)                                                                             \
    do {                                                                                           \
        btg_program_def bad = def;                                                                 \
        bad.change;                                                                                \
        listing_run(l, &d, &bad, path, 1, -1);                                                     \
        CHECK(l->status == BTG_ERROR_ARGUMENT);                                                    \
    } while (0)
    REFUSE(version = 0);
    REFUSE(write = NULL);
    REFUSE(feed_mm_per_min = 0);
    REFUSE(feed_mm_per_min = 1e-300);
    REFUSE(clear_z_mm = NAN);
    REFUSE(approach_mm = -1);
    REFUSE(tolerance_mm = 0);
    REFUSE(cone_rad = 2);
    REFUSE(spindle_rpm = -1);
    REFUSE(tool_number = 100000000);
    REFUSE(window = 1);
}

/* What each control reads, line for line. */
static void expect(const char *name, int tcp, int vectors, const char *text) {
    btg_machine_def d = machine(name);
    btg_program_def def = listing_def(l);
    def.name = "a part";
    d.tcp = tcp;
    d.vectors = vectors;
    if (!tcp) d.inverse_time = 1;
    path[0] = pose(1, 2, 3, 0, 0);
    path[1] = pose(11, 2, 3, 30, 90);
    def.tolerance_mm = 1;
    listing_run(l, &d, &def, path, 2, -1);
    CHECK(l->status == BTG_OK);
    if (strcmp(l->text, text) != 0) fprintf(stderr, "%s %d %d:\n%s", name, tcp, vectors, l->text);
    CHECK(strcmp(l->text, text) == 0);
}

#include "listings.inc"

int main(void) {
    l = calloc(1, sizeof *l);
    if (!l) return 1;
    test_wind_up();
    test_start_in_the_right_turn();
    test_rewind();
    test_one_turn_alone();
    test_no_whole_turn();
    test_clearance();
    test_solutions();
    test_through_the_pole();
    test_on_the_pole();
    test_vectors();
    test_windows();
    test_out_of_reach();
    test_statuses();
    test_linearisation();
    test_speeds();
    test_feed();
    test_numbers();
    test_write_fails();
    test_definitions();
    test_controls();
    free(l);
    return check_result();
}
