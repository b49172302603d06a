/* From positions to a machine: cutter-location data (APT / ISO 4343) as CAM systems and other
 * posts read it, the kinematics of five-axis machines, and programs for their controls.
 *
 * Text leaves through a callback, piece by piece, whatever the length of the path. Numbers are
 * decimal, without exponents, whatever the locale. Angles are radians; programs are in degrees. */
#ifndef BITANGENT_POST_H
#define BITANGENT_POST_H

#include "bitangent/bitangent.h"

#ifdef __cplusplus
extern "C" {
#endif

/* z of the tip, mm, at which the lowest point of the tool (cutter, shank and holder, leaning as
 * `axis` does) stands at clear_z_mm. */
BTG_API double btg_post_lift_z(const btg_tool *tool, btg_vec3 axis, double clear_z_mm);

typedef struct btg_apt_def {
    uint32_t version;
    const char *part_name;  /* PARTNO; may be NULL; what APT cannot spell becomes a blank */
    double feed_mm_per_min; /* FEDRAT; > 0, default 1000 */
    double clear_z_mm;      /* retracts keep the whole tool at or above this height: the part's
                               top plus a clearance; no default */
    /* Takes the next piece of text. An error (< 0) ends the call and is returned by it. */
    btg_status (*write)(const char *text, size_t size, void *user);
    void *user;
} btg_apt_def;

BTG_API btg_apt_def btg_apt_def_default(void);

/* A program being written. The caller owns the memory; the members are private.
 * Thread-safety: one thread at a time. Real-time: no (the callback decides). */
typedef struct btg_apt {
    btg_apt_def def;
    btg_tool tool;
    int placed; /* 1: the tool stands at tip, axis */
    int broken; /* 1: the next position is reached by a retract */
    btg_vec3 tip, axis;
    unsigned long moves; /* GOTO records so far */
} btg_apt;

/* PARTNO, UNITS/MM, MULTAX/ON, CUTTER, FEDRAT. The cutter's height h is the top of shank and
 * holder over the tip, or, without those, 100 mm. ERROR_ARGUMENT: see the members above. */
BTG_API btg_status btg_apt_begin(btg_apt *apt, const btg_apt_def *def, const btg_tool *tool,
                                 btg_message *message);

/* The next position: GOTO/ tip, axis at feed when `link` is 1 and the one before had contact;
 * otherwise a retract to clear_z over the last, RAPID across, and down at feed. A position
 * without contact is left out. The tool moves straight between linked positions: link those of
 * one pass. ERROR_ARGUMENT: tip or axis is not finite. */
BTG_API btg_status btg_apt_add(btg_apt *apt, const btg_position *position, int link);

/* The last retract, PPRINT with the number of GOTO records, so that one that is lost shows, and
 * FINI. */
BTG_API btg_status btg_apt_end(btg_apt *apt);

/* ---- machines ---------------------------------------------------------------------------- */

/* A rotary axis. What it carries, part or tool, turns counter-clockwise seen from the tip of
 * `direction` as its angle grows. Rotary axes of a table that follow ISO 841 (the angle is the
 * tool's motion as seen from the part) therefore point along -x, -y, -z. */
typedef struct btg_rotary_def {
    char letter;             /* 'A', 'B' or 'C' */
    int in_head;             /* 0: carries the part, 1: carries the tool */
    btg_vec3 direction;      /* of the axis with all joints at 0; any length above 0 */
    btg_vec3 pivot;          /* a point on the axis, mm. Table: machine coordinates. Head: from the
                                spindle's nose, with all joints at 0 */
    double min_rad, max_rad; /* limits; -INFINITY, INFINITY where there is none */
    double speed_rad_per_s, acceleration_rad_per_s2; /* > 0 */
} btg_rotary_def;

typedef struct btg_linear_def {
    double min_mm, max_mm;                         /* limits of the joint; may be infinite */
    double speed_mm_per_s, acceleration_mm_per_s2; /* > 0 */
} btg_linear_def;

typedef enum btg_control {
    BTG_CONTROL_LINUXCNC = 0,  /* tool-centre-point control: its kinematics module */
    BTG_CONTROL_FANUC = 1,     /* G43.4, with vectors G43.5 */
    BTG_CONTROL_SIEMENS = 2,   /* TRAORI, with vectors A3= B3= C3= */
    BTG_CONTROL_HEIDENHAIN = 3 /* M128 */
} btg_control;

/* A machine with three linear joints X, Y, Z that move the spindle along the machine's axes and
 * two rotary ones. Joints are 0 where the spindle's nose stands at the machine's origin, not
 * turned. */
typedef struct btg_machine_def {
    uint32_t version;
    char name[64];
    btg_rotary_def
        rotary[2]; /* two in the table or two in the head: the first carries the second */
    btg_linear_def linear[3];
    btg_vec3 part_origin;  /* the part frame's origin in machine coordinates, rotary joints at 0:
                              the work offset (G54) */
    double tool_length_mm; /* nose to tip, default 100 */
    double retract_z_mm;   /* joint Z that is safe everywhere; NaN (default): there is none */

    btg_control control;
    int tcp;     /* 1 (default): the control keeps the tip on the path (tool-centre-point control);
                    0: the program gives joints, linearised */
    int vectors; /* 1: the tool axis as a vector, not as angles; Fanuc and Siemens, with tcp */
    int inverse_time; /* 1: each cutting block says how long it takes (G93, FT), 0: mm per minute */
} btg_machine_def;

/* Without rotary axes: fill those in. */
BTG_API btg_machine_def btg_machine_def_default(void);

/* "xyzac-trt" and "xyzbc-trt" (LinuxCNC's kinematics), "fanuc" (table-table), "siemens"
 * (head-head), "heidenhain" (head-table). Limits and speeds are those of a middling machine: copy
 * and edit. ERROR_ARGUMENT: no such name, or index. */
BTG_API btg_status btg_machine_find(const char *name, btg_machine_def *def);
BTG_API btg_status btg_machine_at(size_t index, btg_machine_def *def);

/* A checked machine. Plain data, copy freely. Thread-safety: read-only. Real-time: yes. */
typedef struct btg_machine {
    btg_machine_def def; /* directions unit */
} btg_machine;

/* ERROR_ARGUMENT with a message "member: reason; remedy": a number not finite, a limit reversed,
 * a letter twice, axes that cannot turn the tool every way (parallel, or the tool's own). */
BTG_API btg_status btg_machine_init(const btg_machine_def *def, btg_machine *machine,
                                    btg_message *message);

typedef struct btg_joints {
    double linear_mm[3];
    double rotary_rad[2]; /* in the order of the machine's definition */
} btg_joints;

/* The joints that put the tip at `tip`, the tool along unit `axis` (part frame): both solutions,
 * rotary angles in -pi..pi, limits not looked at. Where the axis is parallel to a rotary axis that
 * it may turn about at will (the pole) that one is 0. ERROR_ARGUMENT: not finite, axis not unit;
 * ERROR_UNSUPPORTED: the machine cannot turn the tool so. */
BTG_API btg_status btg_machine_inverse(const btg_machine *machine, btg_vec3 tip, btg_vec3 axis,
                                       btg_joints joints[2]);
/* Where the tip stands and the axis points, part frame. */
BTG_API btg_status btg_machine_forward(const btg_machine *machine, const btg_joints *joints,
                                       btg_vec3 *tip, btg_vec3 *axis);

/* The farthest that the tool's axis may lean from +z, every way, within the rotary limits; up to
 * most_rad (0 .. pi/2). Leans are looked at half a degree apart, every degree around, and the first
 * that is out of reach to 1e-9: limits that leave out less than that are not seen. */
BTG_API double btg_machine_max_tilt(const btg_machine *machine, double most_rad);

/* ---- programs for a machine -------------------------------------------------------------- */

typedef struct btg_program_def {
    uint32_t version;
    const char *name;       /* for a comment and the program's name; may be NULL */
    double feed_mm_per_min; /* of the tip; 0.001 to 1e6, default 1000; lowered where joints would be
                               too fast or accelerate too much */
    double clear_z_mm;      /* as for APT; no default */
    double approach_mm;     /* the last bit down to the part is at feed; >= 0, default 2 */
    double tolerance_mm;    /* of the cutter's motion between positions, and of rounding; 1e-6 .. 1,
                               default 0.002 */
    double cone_rad;        /* an axis this close to the pole may be moved onto it; default NaN:
                               as far as the tolerance allows */
    uint32_t tool_number;   /* default 1 */
    double spindle_rpm;     /* default 3000; 0: no spindle words */
    size_t window; /* positions looked ahead over; >= 2, default 262144, some 130 bytes each */
    btg_allocator allocator;
    btg_status (*write)(const char *text, size_t size, void *user); /* as for APT */
    void *user;
    /* Where the joints stand after each block that moves; NULL (default): nobody asks. `seconds`
     * is the block's time, or 0 for a rapid, whose speed is the control's. Gets `user`. */
    void (*trace)(const btg_joints *joints, double seconds, void *user);
} btg_program_def;

BTG_API btg_program_def btg_program_def_default(void);

typedef struct btg_program_info {
    uint64_t positions; /* with contact */
    uint64_t blocks;    /* lines that move */
    uint64_t inserted;  /* blocks between positions, for the tolerance */
    uint64_t slowed;    /* cutting blocks whose feed was lowered */
    uint64_t retracts;  /* ways over clear_z within the path */
    uint64_t rewinds;   /* retracts of which a rotary limit is the reason */
    uint64_t gaps;      /* rewinds that leave a piece uncut: its axes are beyond the limits */
    double cut_seconds; /* of the cutting blocks */
} btg_program_info;

/* A program being written: which of the two solutions and which turn of the rotary axes each
 * position takes is chosen over the whole path, or over `window` positions of it, by dynamic
 * programming: no rewind that can be avoided, then the least turning.
 * Thread-safety: one thread at a time. Real-time: no. */
typedef struct btg_program btg_program;

/* Memory is allocated here, and never again. Errors: ERROR_ARGUMENT, ERROR_MEMORY. */
BTG_API btg_status btg_program_create(const btg_program_def *def, const btg_machine *machine,
                                      const btg_tool *tool, btg_program **program,
                                      btg_message *message);
BTG_API void btg_program_destroy(btg_program *program); /* NULL is fine */

/* The next position, linked as for APT. Positions without contact become retracts.
 * ERROR_UNSUPPORTED: the machine does not reach it; the message says which joint. Other errors:
 * ERROR_ARGUMENT, and what `write` returns. After an error the program is of no use. */
BTG_API btg_status btg_program_add(btg_program *program, const btg_position *position, int link,
                                   btg_message *message);
/* The rest, the last retract and the program's end. `info` may be NULL. */
BTG_API btg_status btg_program_end(btg_program *program, btg_program_info *info,
                                   btg_message *message);

#ifdef __cplusplus
}
#endif
#endif
