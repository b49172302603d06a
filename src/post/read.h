/* Programs read back: words, what they mean to the control, and the way the machine then takes.
 * Internal.
 *
 * Understood is what gcode.c writes and little more: straight moves in absolute millimetres, under
 * tool-centre-point control or as joints. Everything else is refused, with the word: a program that
 * is half understood is not verified. Rapids are taken as straight; corners are not rounded. */
#ifndef BTG_POST_READ_H
#define BTG_POST_READ_H

#include "bitangent/post.h"

#include <stdbool.h>

/* ---- block.c: one line as words ------------------------------------------------------------ */

#define BTG_BLOCK_CODES 16 /* most G words, and most M words, of a line */

typedef enum btg_keyword {
    BTG_KEYWORD_SUPA = 1,
    BTG_KEYWORD_TRAORI = 2,
    BTG_KEYWORD_TRAFOOF = 4,
    BTG_KEYWORD_ORIWKS = 8,
    BTG_KEYWORD_ORIVECT = 16,
    BTG_KEYWORD_ORIAXES = 32,
    BTG_KEYWORD_FMAX = 64,
    BTG_KEYWORD_FT = 128,
    BTG_KEYWORD_L = 256,
    BTG_KEYWORD_BEGIN = 512,
    BTG_KEYWORD_END = 1024,
    BTG_KEYWORD_TOOL = 2048
} btg_keyword;

typedef struct btg_block {
    bool has[26]; /* by letter */
    double value[26];
    bool has_vector[3]; /* A3= B3= C3= */
    double vector[3];
    int g[BTG_BLOCK_CODES], g_count; /* in tenths: G43.4 is 434 */
    int m[BTG_BLOCK_CODES], m_count;
    unsigned keywords;
    double seconds;   /* FT */
    long tool;        /* TOOL CALL */
    long promised[2]; /* a comment "MOVES n OF m BLOCKS"; -1: it does not say */
    bool counted;     /* a comment "BITANGENT ...": the program counts its blocks */
    bool any;         /* something but a comment */
} btg_block;

/* `text` is a line without its end. ERROR_FORMAT: reason; remedy. */
btg_status btg_block_parse(btg_control control, const char *text, btg_block *block,
                           btg_message *message);

/* ---- way.c: how the machine moves ---------------------------------------------------------- */

typedef enum btg_way_kind {
    BTG_WAY_JOINTS, /* all joints evenly */
    BTG_WAY_TCP,    /* the tip straight, the rotary joints evenly */
    BTG_WAY_VECTORS /* the tip straight, the axis evenly in the plane of both */
} btg_way_kind;

typedef struct btg_way {
    btg_way_kind kind;
    btg_vec3 from, to; /* tip in the part frame; BTG_WAY_JOINTS: linear joints */
    double angle_from[2], angle_to[2];
    btg_vec3 axis_from, axis_to; /* BTG_WAY_VECTORS */
    double seconds;              /* > 0: how long it takes */
} btg_way;

typedef struct btg_way_pose {
    btg_vec3 tip, axis;
    btg_vec3 linear; /* joints; not with BTG_WAY_VECTORS: the control chooses them */
    double angle[2];
} btg_way_pose;

void btg_way_at(const btg_machine *machine, const btg_way *way, double part, btg_way_pose *pose);
/* The longest piece from part `from` on, at most `most`, over which the tool differs by no more
 * than `error_mm`, up to reach_mm from the tip, from one whose tip runs straight and whose axis
 * turns evenly. Returns where it ends. */
double btg_way_piece(const btg_machine *machine, const btg_way *way, double from, double most,
                     double error_mm, double reach_mm);
/* Largest speed of a joint on that piece over what the joint can do; *joint: which. */
double btg_way_haste(const btg_machine *machine, const btg_way *way, double from, double to,
                     const btg_way_pose *a, const btg_way_pose *b, int *joint);

/* ---- read.c: the control ------------------------------------------------------------------- */

typedef struct btg_reader {
    const btg_machine *machine;
    double error_mm, reach_mm; /* of the poses between; of the tool, from its tip */
    int motion;                /* 0 rapid, 1 cut, -1 neither yet */
    bool inverse_time, length, tcp, vectors, inside, ended;
    long tool;
    double feed; /* mm per minute; 0: none yet */
    /* Where the machine stands: the tip in the part frame under tcp, else linear joints; and the
     * rotary joints. */
    double at[5];
    bool known[5];
    btg_vec3 axis; /* with vectors */
    bool posed;    /* there was a pose, and it is known how the machine went on from there */

    btg_way way;
    bool under_way;
    double part, step; /* of the way done; of the piece before */
    btg_way_pose last;

    unsigned long moves;  /* lines that move, machine coordinates apart */
    bool counted;         /* it should say how many moves and blocks there are */
    unsigned long blocks; /* lines with more than a comment */
    long promised[2];     /* moves and blocks, by the program; -1: it does not say */
    double haste;         /* largest so far of a joint's speed over what it can do; 0: not known */
    int hasty_joint;
} btg_reader;

void btg_reader_open(btg_reader *reader, const btg_machine *machine, double error_mm,
                     double reach_mm);
/* The next line, when btg_reader_pose has no more. ERROR_FORMAT: reason; remedy. */
btg_status btg_reader_line(btg_reader *reader, const char *text, btg_message *message);

typedef struct btg_reader_place {
    btg_vec3 tip, axis;
    bool linked;  /* the machine moves here from the pose before */
    bool between; /* not yet where the block ends */
} btg_reader_place;

/* The next pose of the last line's motion. *any: there was one. ERROR_UNSUPPORTED: a joint beyond
 * its limits. */
btg_status btg_reader_pose(btg_reader *reader, btg_reader_place *place, bool *any,
                           btg_message *message);

#endif
