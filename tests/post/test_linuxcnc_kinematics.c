/* Our joints against LinuxCNC's own kinematics modules, loaded as they are with HAL left out:
 * 100,000 poses each, both solutions, to 1e-6 mm and degrees. Exit code 77: not installed. */
#define _GNU_SOURCE
#include "../conformance/rng.h"
#include "bitangent/post.h"
#include "core/vec.h"

#include <dlfcn.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#define POSES     100000
#define LIMIT     1e-6 /* mm and degrees, as issue 6 asks */
#define SKIPPED   77
#define PIN_COUNT 64

/* ---- HAL, as far as the modules ask ------------------------------------------------------- */

/* LinuxCNC's EmcPose (emcpos.h). */
typedef struct pose {
    double x, y, z, a, b, c, u, v, w;
} pose;

typedef struct pin {
    char name[64];
    union {
        double number;
        int whole;
    } value;
} pin;

static pin pins[PIN_COUNT];
static int pin_count;
static char heap[65536];
static size_t heap_used;

BTG_API int hal_init(const char *name);
BTG_API int hal_ready(int id);
BTG_API int hal_exit(int id);
BTG_API void *hal_malloc(long size);
BTG_API int hal_pin_float_newf(int direction, double **data, int id, const char *format, ...);
BTG_API int hal_pin_bit_new(const char *name, int direction, void **data, int id);
BTG_API int hal_pin_s32_new(const char *name, int direction, void **data, int id);
BTG_API void rtapi_print(const char *format, ...);
BTG_API void rtapi_print_msg(int level, const char *format, ...);

int hal_init(const char *name) {
    (void)name;
    return 1;
}
int hal_ready(int id) {
    (void)id;
    return 0;
}
int hal_exit(int id) {
    (void)id;
    return 0;
}
void *hal_malloc(long size) {
    void *memory = heap + heap_used;
    heap_used += ((size_t)size + 15) / 16 * 16;
    return heap_used <= sizeof heap ? memory : NULL;
}

static pin *new_pin(void) {
    if (pin_count == PIN_COUNT) abort();
    pins[pin_count] = (pin){.name = ""};
    return &pins[pin_count++];
}

int hal_pin_float_newf(int direction, double **data, int id, const char *format, ...) {
    va_list arguments;
    pin *p = new_pin();
    (void)direction, (void)id;
    va_start(arguments, format);
    vsnprintf(p->name, sizeof p->name, format, arguments);
    va_end(arguments);
    *data = &p->value.number;
    return 0;
}
int hal_pin_bit_new(const char *name, int direction, void **data, int id) {
    (void)name, (void)direction, (void)id;
    *data = &new_pin()->value;
    return 0;
}
int hal_pin_s32_new(const char *name, int direction, void **data, int id) {
    return hal_pin_bit_new(name, direction, data, id);
}
void rtapi_print(const char *format, ...) {
    (void)format;
}
void rtapi_print_msg(int level, const char *format, ...) {
    (void)level, (void)format;
}

static void set(const char *module, const char *name, double value) {
    char whole[128];
    snprintf(whole, sizeof whole, "%s.%s", module, name);
    for (int i = 0; i < pin_count; i++) {
        if (strcmp(pins[i].name, whole) != 0) continue;
        pins[i].value.number = value;
        return;
    }
    fprintf(stderr, "%s: no such pin\n", whole);
    exit(1);
}

/* ---- one module --------------------------------------------------------------------------- */

typedef int forward_function(const double *joint, pose *at, const unsigned long *, unsigned long *);
typedef int inverse_function(const pose *at, double *joint, const unsigned long *, unsigned long *);

typedef struct module {
    const char *name;
    void *library;
    forward_function *forward;
    inverse_function *inverse;
    btg_vec3 rotation_point, offset;
    btg_machine machine;
} module;

static const char *folder(void) {
    const char *given = getenv("LINUXCNC_MODULES");
    return given ? given : "/usr/lib/linuxcnc/modules";
}

static void *function(const module *m, const char *name) {
    void *found = dlsym(m->library, name);
    if (found) return found;
    fprintf(stderr, "%s: no %s\n", m->name, name);
    exit(1);
}

static void load(module *m) {
    char file[512];
    snprintf(file, sizeof file, "%s/%s-kins.so", folder(), m->name);
    if (access(file, R_OK) != 0) {
        printf("LinuxCNC is not installed: no %s\n", file);
        exit(SKIPPED);
    }
    m->library = dlopen(file, RTLD_NOW | RTLD_LOCAL);
    if (!m->library) {
        fprintf(stderr, "%s\n", dlerror());
        exit(1);
    }
    void *start = function(m, "rtapi_app_main");
    int (*start_it)(void);
    memcpy(&start_it, &start, sizeof start);
    void *forward = function(m, "kinematicsForward"), *inverse = function(m, "kinematicsInverse");
    memcpy(&m->forward, &forward, sizeof forward);
    memcpy(&m->inverse, &inverse, sizeof inverse);
    pin_count = 0;
    if (start_it() != 0) {
        fprintf(stderr, "%s: does not start\n", m->name);
        exit(1);
    }
}

/* The same machine for both: rotation point, offsets and tool at random. */
static void set_up(module *m, rng *r) {
    char name[64], tilt = m->name[3];
    btg_machine_def def;
    snprintf(name, sizeof name, "%s-kins", m->name);
    btg_vec3 p = vec(rng_range(r, -300, 300), rng_range(r, -300, 300), rng_range(r, -300, 300));
    btg_vec3 d = vec(0, 0, rng_range(r, -50, 50));
    if (tilt == 'a') d.y = rng_range(r, -50, 50);
    if (tilt == 'b') d.x = rng_range(r, -50, 50);
    if (btg_machine_find(m->name, &def) != BTG_OK) exit(1);
    def.tool_length_mm = rng_range(r, 0, 200);
    def.rotary[1].pivot = p;
    def.rotary[0].pivot = vec_add(p, d);
    def.part_origin = vec(rng_range(r, -100, 100), rng_range(r, -100, 100), 20);
    if (btg_machine_init(&def, &m->machine, NULL) != BTG_OK) exit(1);
    set(name, "x-rot-point", p.x);
    set(name, "y-rot-point", p.y);
    set(name, "z-rot-point", p.z);
    if (tilt == 'a') set(name, "y-offset", d.y);
    if (tilt == 'b') set(name, "x-offset", d.x);
    set(name, "z-offset", d.z);
    set(name, "tool-offset", def.tool_length_mm);
}

#define DEGREES(x) ((x) * (180 / BTG_PI))

/* What a program asks for: the tip over the work offset, tool length compensation in Z. */
static pose asked(const module *m, btg_vec3 tip, const double rotary[2]) {
    btg_vec3 p = vec_add(tip, m->machine.def.part_origin);
    pose at = {.x = p.x, .y = p.y, .z = p.z + m->machine.def.tool_length_mm};
    double *tilt = m->name[3] == 'a' ? &at.a : &at.b;
    *tilt = DEGREES(rotary[0]);
    at.c = DEGREES(rotary[1]);
    return at;
}

static double worst(const double *a, const double *b, int count) {
    double most = 0;
    for (int i = 0; i < count; i++) {
        double off = fabs(a[i] - b[i]);
        if (!(off <= most)) most = off;
    }
    return most;
}

static double check_pose(const module *m, rng *r) {
    btg_vec3 tip = vec(rng_range(r, -200, 200), rng_range(r, -200, 200), rng_range(r, -50, 200));
    double lean = rng_range(r, 0, 1) < 0.2 ? pow(10, rng_range(r, -6, -1)) : rng_range(r, 0, 2);
    double round = rng_range(r, -BTG_PI, BTG_PI), most = 0;
    btg_vec3 axis = vec(sin(lean) * cos(round), sin(lean) * sin(round), cos(lean));
    btg_joints joints[2];
    if (btg_machine_inverse(&m->machine, tip, axis, joints) != BTG_OK) return INFINITY;
    for (int k = 0; k < 2; k++) {
        const btg_joints *j = &joints[k];
        double ours[5] = {j->linear_mm[0], j->linear_mm[1], j->linear_mm[2],
                          DEGREES(j->rotary_rad[0]), DEGREES(j->rotary_rad[1])};
        double theirs[9] = {0};
        unsigned long flags = 0;
        pose at = asked(m, tip, j->rotary_rad), back = at;
        if (m->inverse(&at, theirs, &flags, &flags) != 0) return INFINITY;
        most = fmax(most, worst(ours, theirs, 5));
        if (m->forward(ours, &back, &flags, &flags) != 0) return INFINITY;
        most = fmax(most, worst(&back.x, &at.x, 6));
        /* The axis is known to LinuxCNC only through what its kinematics do to a longer tool. */
        btg_vec3 end = vec_mad(tip, axis, 100);
        pose far = asked(m, end, j->rotary_rad);
        double reach[9] = {0};
        if (m->inverse(&far, reach, &flags, &flags) != 0) return INFINITY;
        double tool[3] = {theirs[0], theirs[1], theirs[2] + 100};
        most = fmax(most, worst(tool, reach, 3));
    }
    return most;
}

static int check_module(const char *name) {
    module m = {.name = name};
    rng r = rng_of(20240607, name, 0);
    double most = 0;
    load(&m);
    for (int i = 0; i < POSES; i++) {
        if (i % 1000 == 0) set_up(&m, &r);
        double off = check_pose(&m, &r);
        if (!(off <= most)) most = off;
    }
    printf("%s: %d poses, largest difference %.3g mm or degrees\n", name, POSES, most);
    return !(most <= LIMIT);
}

int main(void) {
    int bad = check_module("xyzac-trt");
    bad += check_module("xyzbc-trt");
    return bad > 0;
}
