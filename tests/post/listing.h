/* A program in memory, run: what a test asks of one. */
#ifndef BTG_TESTS_POST_LISTING_H
#define BTG_TESTS_POST_LISTING_H

#include "../unit/check.h"
#include "bitangent/post.h"
#include "core/vec.h"

#include <stdlib.h>
#include <string.h>

#define RADIANS(x) ((x) * (BTG_PI / 180))
#define DEGREES(x) ((x) * (180 / BTG_PI))

#define LISTING_SIZE   (1 << 22)
#define LISTING_BLOCKS 40000

/* One motion line, with the words that were left out filled in. */
typedef struct block {
    bool rapid;
    double word[5]; /* X Y Z and the two rotary joints, mm and degrees */
    double feed;    /* on this line or before */
} block;

typedef struct listing {
    char text[LISTING_SIZE];
    size_t size, room;
    block blocks[LISTING_BLOCKS];
    int count;
    btg_program_info info;
    btg_message message;
    btg_status status; /* of the first call that failed */
} listing;

static inline btg_status listing_write(const char *text, size_t size, void *user) {
    listing *l = user;
    if (size > l->room - l->size) return BTG_ERROR_FILE;
    memcpy(l->text + l->size, text, size);
    l->size += size;
    l->text[l->size] = '\0';
    return BTG_OK;
}

static inline btg_position pose(double x, double y, double z, double lean_deg, double round_deg) {
    double lean = RADIANS(lean_deg), round = RADIANS(round_deg);
    btg_position p = {.tip = {x, y, z}};
    p.axis = vec(sin(lean) * cos(round), sin(lean) * sin(round), cos(lean));
    return p;
}

static inline btg_tool listing_tool(void) {
    btg_tool_def def = btg_tool_def_default();
    btg_tool tool = {.def = def};
    CHECK(btg_tool_init(&def, &tool, NULL) == BTG_OK);
    return tool;
}

static inline btg_program_def listing_def(listing *l) {
    btg_program_def def = btg_program_def_default();
    def.clear_z_mm = 50;
    def.write = listing_write;
    def.user = l;
    l->room = sizeof l->text - 1;
    return def;
}

/* Splits the motion lines of G-code (not Heidenhain's). */
static inline void listing_parse(listing *l, const btg_machine_def *d) {
    block now = {.rapid = true, .word = {NAN, NAN, NAN, NAN, NAN}};
    const char letters[5] = {'X', 'Y', 'Z', d->rotary[0].letter, d->rotary[1].letter};
    l->count = 0;
    for (const char *s = l->text; *s; s += strcspn(s, "\n") + 1) {
        if (strncmp(s, "G0 ", 3) != 0 && strncmp(s, "G1 ", 3) != 0) continue;
        now.rapid = s[1] == '0';
        for (const char *w = s; *w && *w != '\n'; w++) {
            if (w[-1] != ' ') continue;
            for (int i = 0; i < 5; i++)
                if (*w == letters[i]) now.word[i] = strtod(w + 1, NULL);
            if (*w == 'F') now.feed = strtod(w + 1, NULL);
        }
        if (l->count < LISTING_BLOCKS) l->blocks[l->count++] = now;
    }
}

/* A whole program; links between all positions but the first, and but those after a `cut`. */
static inline void listing_run(listing *l, const btg_machine_def *machine_def,
                               const btg_program_def *def, const btg_position *positions, int count,
                               int cut) {
    btg_machine machine = {.def = *machine_def};
    btg_tool tool = listing_tool();
    btg_program *p = NULL;
    l->size = 0;
    l->text[0] = '\0';
    l->status = btg_machine_init(machine_def, &machine, &l->message);
    if (l->status == BTG_OK) {
        l->status = btg_program_create(def, &machine, &tool, &p, &l->message);
    }
    for (int i = 0; i < count && l->status == BTG_OK; i++) {
        l->status = btg_program_add(p, &positions[i], i != cut, &l->message);
    }
    if (l->status == BTG_OK) l->status = btg_program_end(p, &l->info, &l->message);
    btg_program_destroy(p);
    if (l->status == BTG_OK) listing_parse(l, machine_def);
}

/* Where a block puts the tip and the axis, for a machine that has tool-centre-point control or not.
 */
static inline void listing_pose(const btg_machine *m, const double word[5], btg_vec3 *tip,
                                btg_vec3 *axis) {
    btg_joints q = {{word[0], word[1], word[2]}, {RADIANS(word[3]), RADIANS(word[4])}};
    const btg_vec3 o = m->def.part_origin;
    q.linear_mm[0] += o.x;
    q.linear_mm[1] += o.y;
    q.linear_mm[2] += o.z + m->def.tool_length_mm;
    CHECK(btg_machine_forward(m, &q, tip, axis) == BTG_OK);
    if (m->def.tcp) *tip = vec(word[0], word[1], word[2]);
}

#endif
