/* Reads a part from glTF 2.0 (.gltf or .glb). The one place where units and axes are converted.
 * A library of its own (libbitangent-gltf): it needs C++ and tinygltf, the core does not. */
#ifndef BITANGENT_GLTF_H
#define BITANGENT_GLTF_H

#include "bitangent/bitangent.h"

#ifdef __cplusplus
extern "C" {
#endif

typedef enum btg_gltf_unit { BTG_GLTF_METRE = 0, BTG_GLTF_MILLIMETRE = 1 } btg_gltf_unit;
typedef enum btg_gltf_up { BTG_GLTF_UP_Y = 0, BTG_GLTF_UP_Z = 1 } btg_gltf_up;

typedef struct btg_gltf_def {
    uint32_t version;
    btg_gltf_unit unit;      /* unit of the file's coordinates; default metre */
    btg_gltf_up up;          /* up axis of the file; default y: x = X, y = -Z, z = Y */
    int use_mesh;            /* 1: ignore exact surfaces, take the triangles beside them */
    uint64_t max_file_bytes; /* a larger file is refused, and so is one whose buffers hold more
                                than this together; default 1 GiB */
    btg_allocator allocator; /* for the part */
} btg_gltf_def;

BTG_API btg_gltf_def btg_gltf_def_default(void);

/* All meshes of the default scene (scene 0 when none is named, all root nodes when there are no
 * scenes), node transforms applied, as one part. Skins, morph targets, images, animations and
 * cameras are ignored; points and lines too.
 *
 * Exact surfaces come from BITANGENT_tensor_surface on primitives and from
 * KITTYCAD_boundary_representation: a solid whose faces are all whole NURBS surfaces (a face counts
 * as whole without loops, or when its one loop runs over the surface's corners only) takes the
 * place of its node's mesh; root-level surfaces without solids and faces take the place of all
 * meshes. A solid with other faces is its mesh's triangles. A primitive without exact surfaces is
 * its triangles, as they are.
 *
 * Every byte is treated as hostile. Buffers may lie in the file's own folder and below it, nowhere
 * else; nothing is written, no other file is opened.
 *
 * *part is untouched on error. Errors: ERROR_ARGUMENT (NULL, unknown version, unit or axis),
 * ERROR_FILE (a file cannot be opened), ERROR_FORMAT (malformed), ERROR_UNSUPPORTED (a required
 * extension, compression, a solid that is not NURBS and has no triangles), ERROR_MEMORY (too large,
 * or no memory). The message is one line: file, JSON path of the fault, reason, remedy. On success
 * the message is empty, or one line that says why triangles stand in for an exact solid.
 * Thread-safety: reentrant. Real-time: no. */
BTG_API btg_status btg_gltf_load(const char *path, const btg_gltf_def *def, btg_part **part,
                                 btg_message *message);

#ifdef __cplusplus
}
#endif
#endif
