/* Cutter-location data from positions: APT / ISO 4343 as CAM systems and posts read it.
 *
 * Text leaves through a callback, piece by piece, whatever the length of the path; nothing is
 * allocated. Numbers are decimal, without exponents, whatever the locale. */
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

/* The last retract and FINI. */
BTG_API btg_status btg_apt_end(btg_apt *apt);

#ifdef __cplusplus
}
#endif
#endif
