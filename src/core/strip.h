/* The width of the strip that a placed tool machines. Internal. */
#ifndef BTG_CORE_STRIP_H
#define BTG_CORE_STRIP_H

#include "core/part.h"
#include "core/ray.h"

typedef struct btg_strip_query {
    const btg_part *part;
    const btg_tool *tool;
    btg_placement pose; /* the tool as placed */
    btg_vec3 across;    /* unit, horizontal, at right angles to the feed */
    double scallop_mm;
} btg_strip_query;

typedef struct btg_strip {
    double width_mm; /* about both contacts together; what both cover counts once */
    double crest_mm; /* farthest from the tool between the contacts; NaN: not known */
    double span_mm;  /* from end to end, what is too far between them included */
    double apart_mm; /* of the contacts, across the feed; 0 without q */
} btg_strip;

/* q may be NULL. */
btg_strip btg_strip_measure(const btg_strip_query *query, const btg_contact *p,
                            const btg_contact *q);

#endif
