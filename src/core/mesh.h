/* Triangle meshes. Internal; set-up only. */
#ifndef BTG_CORE_MESH_H
#define BTG_CORE_MESH_H

#include "core/part.h"

/* Items are numbered in 32 bits, patches and triangles together. */
#define BTG_TRIANGLES_MAX 1000000000u

btg_status btg_mesh_check(const btg_mesh_def *def, size_t index, btg_message *message);

/* Copies a checked mesh to the part's arrays, from these places on. */
void btg_mesh_append(btg_part *part, const btg_mesh_def *def, size_t vertex_at, size_t triangle_at);

#endif
