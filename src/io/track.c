#include "io/track.h"
#include "core/part.h"

#include <ctype.h>
#include <errno.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>

#define CSV_COLUMNS     12
#define BYTE_ORDER_MARK "\xef\xbb\xbf"
#define COLUMNS_MAX     64
#define AXIS_LENGTH_MIN 1e-6
#define ROW_MAX         1e15 /* a double counts up to there */
#define MM_PER_INCH     25.4
/* Feet are written with all their digits. */
#define FOOT_TOLERANCE_MM 1e-6
/* A cutter's diameter and its two radii, as APT gives them, agree this well. */
#define CUTTER_AGREES 1e-4

static const char *const csv_column[CSV_COLUMNS] = {"pass",   "point", "status", "tip_x",
                                                    "tip_y",  "tip_z", "axis_x", "axis_y",
                                                    "axis_z", "row",   "foot_x", "foot_y"};

static btg_status fail(const btg_track *t, btg_message *message, const char *reason) {
    return btg_fail(message, BTG_ERROR_FORMAT, "%.256s:%llu: %s", t->path,
                    (unsigned long long)t->line, reason);
}

static btg_status fail_file(const btg_track *t, int error, btg_message *message) {
    return btg_fail(message, BTG_ERROR_FILE, "%.256s: cannot read: %s; give a readable tool path",
                    t->path, strerror(error));
}

/* One line without its end, at `used` of the text. */
static btg_status get_line(btg_track *t, size_t used, size_t *size, bool *ended,
                           btg_message *message) {
    t->line++;
    errno = 0;
    char *line = t->text + used;
    size_t room = sizeof t->text - used;
    memset(line, 1, room);
    if (!fgets(line, (int)room, t->file)) {
        if (ferror(t->file)) return fail_file(t, errno ? errno : EIO, message);
        line[0] = '\0';
        *size = used;
        *ended = true;
        return BTG_OK;
    }
    /* fgets ends what it read with a zero; bytes after the first zero that are not the filling's
     * mean that it was in the file. */
    size_t n = strlen(line);
    if (n + 1 < room && line[n + 1] != 1)
        return fail(t, message, "a zero byte; give a tool path as text");
    if (n + 1 == room && line[n - 1] != '\n')
        return fail(t, message, "the line is longer than 4000 characters; give a tool path");
    while (n > 0 && (line[n - 1] == '\n' || line[n - 1] == '\r'))
        line[--n] = '\0';
    *size = used + n;
    *ended = false;
    return BTG_OK;
}

/* The whole of text[0 .. size - 1] as a decimal number; NaN counts where `nan` is true. */
static bool number(const char *text, size_t size, bool nan, double *value) {
    char copy[64], *end;
    while (size > 0 && isspace((unsigned char)*text))
        text++, size--;
    while (size > 0 && isspace((unsigned char)text[size - 1]))
        size--;
    if (size == 0 || size >= sizeof copy) return false;
    memcpy(copy, text, size);
    copy[size] = '\0';
    if (nan && strcasecmp(copy, "nan") == 0) {
        *value = NAN;
        return true;
    }
    if (strspn(copy, "+-.0123456789eE") != size) return false;
    *value = strtod(copy, &end);
    return end == copy + size && isfinite(*value);
}

static btg_status place(const btg_track *t, btg_vec3 tip, btg_vec3 axis, btg_verify_pose *pose,
                        btg_message *message) {
    double length = vec_norm(axis);
    if (!(fabs(tip.x) <= BTG_LENGTH_MAX && fabs(tip.y) <= BTG_LENGTH_MAX &&
          fabs(tip.z) <= BTG_LENGTH_MAX))
        return fail(t, message, "the tip is more than 1e6 mm away; give millimetres");
    if (!(length >= AXIS_LENGTH_MIN))
        return fail(t, message, "the tool axis has no length; give its direction, tip to holder");
    pose->tip = tip;
    pose->axis = vec_scale(axis, 1 / length);
    pose->line = t->line;
    if (pose->axis.z < 1e-3)
        return fail(t, message, "the tool axis does not point up; only cuts from +z are verified");
    return BTG_OK;
}

/* ---- CSV ---------------------------------------------------------------------------------- */

/* The column is one of the names'. */
static void find_name(const char *const *names, int count, const char *text, size_t size,
                      int column, int *columns) {
    for (int i = 0; i < count; i++)
        if (strlen(names[i]) == size && strncmp(text, names[i], size) == 0) columns[i] = column;
}

static btg_status csv_header(btg_track *t, btg_message *message) {
    size_t size;
    bool ended;
    btg_status status = get_line(t, 0, &size, &ended, message);
    if (status < 0) return status;
    for (int i = 0; i < CSV_COLUMNS; i++)
        t->column[i] = -1;
    for (int i = 0; i < BTG_ROW_VALUES; i++)
        t->value_column[i] = -1;
    const char *s = t->text;
    if (strncmp(s, BYTE_ORDER_MARK, 3) == 0) s += 3;
    for (t->columns = 0; t->columns < COLUMNS_MAX; t->columns++) {
        size_t n = strcspn(s, ",");
        find_name(csv_column, CSV_COLUMNS, s, n, t->columns, t->column);
        find_name(btg_row_names, BTG_ROW_VALUES, s, n, t->columns, t->value_column);
        if (s[n] == '\0') break;
        s += n + 1;
    }
    t->columns++;
    for (int i = 3; i < 9; i++)
        if (t->column[i] < 0)
            return fail(t, message,
                        "no columns tip_x ... axis_z in the first line; give a path written by "
                        "'bitangent path -o path.csv'");
    t->whole = t->column[0] >= 0 && t->column[1] >= 0 && t->column[2] >= 0;
    for (int i = 0; i < BTG_ROW_VALUES; i++)
        t->whole = t->whole && t->value_column[i] >= 0;
    t->told = t->def.rows && t->whole;
    return BTG_OK;
}

/* All that the line says into t->row. */
static btg_status csv_tell(btg_track *t, const btg_verify_pose *pose, btg_message *message) {
    double value[BTG_ROW_VALUES];
    char status[32] = "";
    const char *s = t->text;
    for (int column = 0;; column++) {
        size_t n = strcspn(s, ",");
        if (column == t->column[2] && n < sizeof status) {
            memcpy(status, s, n);
            status[n] = '\0';
        }
        for (int i = 0; i < BTG_ROW_VALUES; i++)
            if (t->value_column[i] == column && !number(s, n, true, &value[i]))
                return fail(t, message, "not a number; give a path as written");
        if (s[n] == '\0') break;
        s += n + 1;
    }
    t->row = (btg_row){.pass = pose->pass, .point = pose->point};
    if (btg_row_read(&t->row, status, value)) return BTG_OK;
    return fail(t, message, "unknown status; give a path as written");
}

/* Points left out since the row before, by numbers that skip; a pass that is not there counts as
 * one. */
static uint64_t skipped_points(const btg_track *t, uint32_t pass, uint32_t point) {
    uint64_t skipped = 0;
    if (t->column[0] < 0 || t->column[1] < 0) return 0;
    if (!t->numbered || pass != t->last_pass)
        skipped = point;
    else if (point > t->last_point + 1)
        skipped = point - t->last_point - 1;
    if (t->numbered && pass > t->last_pass + 1) skipped += pass - t->last_pass - 1;
    if (!t->numbered && pass > 0) skipped++;
    return skipped;
}

/* Points left out at the end of this pass, or of those before if it is longer: all straight passes
 * along y have as many. */
static uint64_t skipped_end(btg_track *t) {
    uint32_t end = t->last_point, before = t->any_pass ? t->pass_end : end;
    if (!t->numbered || !t->whole) return 0;
    t->any_pass = true;
    t->pass_end = end > before ? end : before;
    return end > before ? end - before : before - end;
}

/* Rows left out; one that is out of its order counts as one. */
static uint64_t skipped_rows(const btg_track *t, uint64_t row) {
    return row > t->last_row ? row - t->last_row - 1 : 1;
}

static void add_missing(btg_track *t, uint64_t skipped, uint32_t pass, uint32_t point) {
    if (skipped > 0 && t->missing == 0) {
        t->missing_pass = pass;
        t->missing_point = point;
    }
    t->missing += skipped;
}

static void check_numbers(btg_track *t, uint32_t pass, uint32_t point, double row) {
    uint64_t before = t->numbered && pass != t->last_pass ? skipped_end(t) : 0;
    uint64_t skipped = t->column[9] >= 0 ? skipped_rows(t, (uint64_t)row)
                                         : before + skipped_points(t, pass, point);
    add_missing(t, skipped, pass, point);
    t->numbered = true;
    t->last_pass = pass;
    t->last_point = point;
    t->last_row = (uint64_t)row;
}

/* Where passes begin and end. */
static void note_foot(btg_track *t, bool same, const double foot[2]) {
    if (t->numbered && same && foot[0] != t->last_foot_x) t->whole = false;
    if (!t->numbered || !same) t->passes++;
    if (!t->numbered) memcpy(t->first_foot, foot, sizeof t->first_foot);
    if (t->passes == 1) t->first_end_y = foot[1];
    if (t->passes == 2) t->second_foot_x = foot[0];
    t->last_foot_x = foot[0];
}

/* No two rows of ours are the same: points have numbers, lifts another status. Rows that are
 * numbered tell by that. */
static void note_doubled(btg_track *t, size_t size) {
    bool told = t->column[0] >= 0 && t->column[1] >= 0 && t->column[9] < 0;
    if (told && strcmp(t->text, t->before) == 0 && t->doubled++ == 0) t->doubled_line = t->line;
    memcpy(t->before, t->text, size + 1);
}

static btg_status csv_row(btg_track *t, btg_verify_pose *pose, bool *contact,
                          btg_message *message) {
    double v[CSV_COLUMNS] = {0};
    const char *s = t->text;
    int column = 0;
    for (;; column++) {
        size_t n = strcspn(s, ",");
        for (int i = 0; i < CSV_COLUMNS; i++) {
            if (t->column[i] != column || i == 2) continue;
            if (!number(s, n, true, &v[i]))
                return fail(t, message, "not a number; give a path as written");
        }
        if (s[n] == '\0') break;
        s += n + 1;
    }
    if (column + 1 != t->columns)
        return fail(t, message, "not as many columns as in the first line; the file is cut short?");
    if (!(v[0] >= 0 && v[0] <= UINT32_MAX && v[1] >= 0 && v[1] <= UINT32_MAX))
        return fail(t, message, "pass and point are no counts; give whole numbers from 0");
    if (!(v[9] >= 0 && v[9] <= ROW_MAX))
        return fail(t, message, "row is no count; give whole numbers from 1");
    bool same = t->numbered && (uint32_t)v[0] == t->last_pass;
    if (t->column[0] < 0) same = true;
    note_foot(t, same, &v[10]);
    check_numbers(t, (uint32_t)v[0], (uint32_t)v[1], v[9]);
    *contact = !isnan(v[3]);
    if (!*contact) {
        t->linked = false;
        return BTG_OK;
    }
    *pose = (btg_verify_pose){.pass = (uint32_t)v[0], .point = (uint32_t)v[1]};
    pose->link = t->linked && (same || t->def.link_all);
    t->linked = true;
    return place(t, vec(v[3], v[4], v[5]), vec(v[6], v[7], v[8]), pose, message);
}

static btg_status csv_next(btg_track *t, btg_verify_pose *pose, bool *ended, btg_message *message) {
    for (bool contact = false; !contact;) {
        size_t size;
        btg_status status = get_line(t, 0, &size, ended, message);
        if (status == BTG_OK && *ended) add_missing(t, skipped_end(t), t->last_pass, t->pass_end);
        if (status < 0 || *ended) return status;
        if (size == 0) continue;
        note_doubled(t, size);
        status = csv_row(t, pose, &contact, message);
        if (status == BTG_OK && contact && t->told) status = csv_tell(t, pose, message);
        if (status < 0) return status;
    }
    return BTG_OK;
}

/* ---- APT ---------------------------------------------------------------------------------- */

/* The next record: lines that end in $ go on, $$ begins a remark. */
static btg_status apt_record(btg_track *t, bool *ended, btg_message *message) {
    size_t size = 0, used = 0;
    bool more = true;
    while (more) {
        bool end;
        btg_status status = get_line(t, used, &size, &end, message);
        if (status < 0) return status;
        if (end) {
            *ended = used == 0;
            return used == 0 ? BTG_OK
                             : fail(t, message, "the file ends within a record; it is cut short");
        }
        char *remark = strstr(t->text + used, "$$");
        if (remark) *remark = '\0';
        size = strlen(t->text);
        while (size > used && isspace((unsigned char)t->text[size - 1]))
            t->text[--size] = '\0';
        more = size > used && t->text[size - 1] == '$';
        if (more) t->text[--size] = '\0';
        used = size;
    }
    *ended = false;
    return BTG_OK;
}

static bool begins(const char *text, const char *word, const char **rest) {
    text += strspn(text, " \t");
    size_t n = strlen(word);
    if (strncasecmp(text, word, n) != 0 || isalnum((unsigned char)text[n])) return false;
    text += n;
    *rest = text + strspn(text, " \t");
    return true;
}

/* Numbers after the slash; -1: something else is there too. */
static int values(const char *rest, double *value, int most) {
    if (*rest != '/') return -1;
    rest++;
    for (int n = 0; n < most;) {
        size_t size = strcspn(rest, ",");
        if (!number(rest, size, false, &value[n])) return -1;
        n++;
        if (rest[size] == '\0') return n;
        rest += size + 1;
    }
    return -1;
}

static btg_status apt_cutter(btg_track *t, const char *rest, btg_message *message) {
    double v[7] = {0};
    int n = values(rest, v, 7);
    if (n < 2) return fail(t, message, "CUTTER/ without diameter and corner radius; give both");
    t->minor_radius_mm = t->scale * v[1];
    t->major_radius_mm = t->scale * (0.5 * v[0] - v[1]);
    if (fabs(t->major_radius_mm) < CUTTER_AGREES) t->major_radius_mm = 0;
    if (!(t->major_radius_mm >= 0 && t->minor_radius_mm >= 0) ||
        (n >= 3 && fabs(t->scale * v[2] - t->major_radius_mm) > CUTTER_AGREES))
        return fail(t, message, "CUTTER/ is no ball, flat or corner-radius cutter; give --tool");
    t->cutter = true;
    return BTG_OK;
}

static btg_status apt_goto(btg_track *t, const char *rest, btg_verify_pose *pose,
                           btg_message *message) {
    double v[6] = {0, 0, 0, t->axis.x, t->axis.y, t->axis.z};
    int n = values(rest, v, 6);
    if (n != 3 && n != 6)
        return fail(t, message, "GOTO/ takes x, y, z and the axis i, j, k; give 3 or 6 numbers");
    *pose = (btg_verify_pose){.point = t->last_point++, .link = t->linked};
    t->linked = true;
    t->axis = vec(v[3], v[4], v[5]);
    return place(t, vec_scale(vec(v[0], v[1], v[2]), t->scale), vec(v[3], v[4], v[5]), pose,
                 message);
}

/* Our own count, of what is printed for the machine's operator. */
static void apt_print(btg_track *t, const char *rest) {
    unsigned long moves;
    if (sscanf(rest, "MOVES %9lu", &moves) == 1) t->promised = (long)moves;
}

static void apt_end(btg_track *t) {
    if (t->promised >= 0) t->missing = (uint64_t)labs(t->promised - (long)t->last_point);
    t->ended = true;
}

static btg_status apt_next(btg_track *t, btg_verify_pose *pose, bool *ended, btg_message *message) {
    static const char *const motions[] = {"GODLTA", "CIRCLE", "CYCLE",  "MOVARC",
                                          "GOHOME", "GOBACK", "TRACUT", "COPY",
                                          "ORIGIN", "TRANS",  "TLAXIS"};
    for (;;) {
        const char *rest;
        *ended = t->ended;
        if (t->ended) return BTG_OK;
        btg_status status = apt_record(t, ended, message);
        if (status < 0 || *ended) return status;
        if (begins(t->text, "GOTO", &rest)) return apt_goto(t, rest, pose, message);
        if (begins(t->text, "PPRINT", &rest)) apt_print(t, rest);
        if (begins(t->text, "FINI", &rest)) apt_end(t);
        if (begins(t->text, "UNITS", &rest)) t->scale = strstr(rest, "INCH") ? MM_PER_INCH : 1;
        if (begins(t->text, "CUTTER", &rest)) status = apt_cutter(t, rest, message);
        for (size_t i = 0; i < sizeof motions / sizeof *motions && status == BTG_OK; i++)
            if (begins(t->text, motions[i], &rest))
                status = fail(t, message,
                              "moves or turns other than GOTO/; write the path as GOTO/ alone");
        if (status < 0) return status;
    }
}

/* ---- programs ------------------------------------------------------------------------------ */

static btg_status fail_program(const btg_track *t, btg_status status, const btg_message *why,
                               btg_message *message) {
    return btg_fail(message, status, "%.256s:%llu: %.200s", t->path, (unsigned long long)t->line,
                    why->text);
}

static btg_status program_end(btg_track *t, btg_message *message) {
    const btg_reader *r = &t->reader;
    if (!r->ended)
        return fail(t, message, "the program does not end (M2, M30, END PGM); it is cut short");
    uint64_t moves = 0, blocks = 0;
    if (r->promised[0] >= 0) moves = (uint64_t)labs(r->promised[0] - (long)r->moves);
    if (r->promised[1] >= 0) blocks = (uint64_t)labs(r->promised[1] - (long)r->blocks);
    t->missing = moves > blocks ? moves : blocks;
    if (r->counted && r->promised[0] < 0) t->missing = 1;
    return BTG_OK;
}

static btg_status program_next(btg_track *t, btg_verify_pose *pose, bool *ended,
                               btg_message *message) {
    btg_reader *r = &t->reader;
    for (;;) {
        btg_message why;
        btg_reader_place p;
        bool any;
        double haste = r->haste;
        btg_status status = btg_reader_pose(r, &p, &any, &why);
        if (status < 0) return fail_program(t, status, &why, message);
        if (r->haste > haste) t->hasty_line = t->line;
        if (any) {
            *pose = (btg_verify_pose){.link = p.linked, .between = p.between};
            return place(t, p.tip, p.axis, pose, message);
        }
        size_t size;
        status = get_line(t, 0, &size, ended, message);
        if (status < 0) return status;
        if (*ended) return program_end(t, message);
        status = btg_reader_line(r, t->text, &why);
        if (status < 0) return fail_program(t, status, &why, message);
    }
}

/* ---- all ------------------------------------------------------------------------------------ */

static bool kind_of(const char *path, btg_track_kind *kind) {
    static const struct {
        const char *ending;
        btg_track_kind kind;
    } known[] = {{".csv", BTG_TRACK_CSV},    {".cl", BTG_TRACK_APT},
                 {".apt", BTG_TRACK_APT},    {".ngc", BTG_TRACK_PROGRAM},
                 {".nc", BTG_TRACK_PROGRAM}, {".mpf", BTG_TRACK_PROGRAM},
                 {".h", BTG_TRACK_PROGRAM}};
    const char *slash = strrchr(path, '/'), *dot = strrchr(slash ? slash : path, '.');
    for (size_t i = 0; dot && i < sizeof known / sizeof *known; i++) {
        if (strcasecmp(dot, known[i].ending) != 0) continue;
        *kind = known[i].kind;
        return true;
    }
    return false;
}

static btg_status next(btg_track *t, btg_verify_pose *pose, bool *ended, btg_message *message) {
    switch (t->kind) {
    case BTG_TRACK_CSV:
        return csv_next(t, pose, ended, message);
    case BTG_TRACK_APT:
        return apt_next(t, pose, ended, message);
    default:
        return program_next(t, pose, ended, message);
    }
}

static btg_status start(btg_track *t, btg_message *message) {
    bool ended = false;
    btg_status status = BTG_OK;
    if (t->kind == BTG_TRACK_CSV) status = csv_header(t, message);
    if (status == BTG_OK) status = next(t, &t->ahead, &ended, message);
    if (status < 0) return status;
    if (ended)
        return btg_fail(message, BTG_ERROR_FORMAT,
                        "%.256s: no position with contact; give a tool path", t->path);
    t->has_ahead = true;
    return BTG_OK;
}

btg_status btg_track_open(btg_track *track, const btg_track_def *def, const char *path,
                          btg_message *message) {
    *track = (btg_track){.path = path, .scale = 1, .def = *def, .axis = {0, 0, 1}, .promised = -1};
    if (!kind_of(path, &track->kind))
        return btg_fail(message, BTG_ERROR_FORMAT,
                        "%.256s: unknown kind of path; give .csv, .cl (APT) or .ngc", path);
    if (track->kind == BTG_TRACK_PROGRAM) {
        if (!def->machine)
            return btg_fail(message, BTG_ERROR_FORMAT,
                            "%.256s: a program for a machine; say which with --machine", path);
        btg_reader_open(&track->reader, def->machine, def->error_mm, def->reach_mm);
    }
    track->file = fopen(path, "r");
    if (!track->file) return fail_file(track, errno, message);
    btg_status status = start(track, message);
    if (status < 0) btg_track_close(track);
    return status;
}

btg_status btg_track_next(btg_track *t, btg_verify_pose *pose, bool *ended, btg_message *message) {
    *ended = false;
    if (t->has_ahead) {
        t->has_ahead = false;
        *pose = t->ahead;
        return BTG_OK;
    }
    return next(t, pose, ended, message);
}

void btg_track_end(btg_track *t, btg_vec3 box_min, btg_vec3 box_max) {
    double overrun = box_min.x - t->first_foot[0], left = box_max.x + overrun - t->last_foot_x;
    /* Feet of a file's are one pass, of any shape. */
    bool ours = t->kind == BTG_TRACK_CSV && t->whole && t->passes > 1 &&
                overrun >= -FOOT_TOLERANCE_MM &&
                fabs(box_min.y - overrun - t->first_foot[1]) <= FOOT_TOLERANCE_MM &&
                fabs(box_max.y + overrun - t->first_end_y) <= FOOT_TOLERANCE_MM;
    if (!ours || !(left > FOOT_TOLERANCE_MM)) return;
    double step = t->second_foot_x - t->first_foot[0];
    if (!(step > FOOT_TOLERANCE_MM)) return;
    double passes = fmin(ceil(left / step - FOOT_TOLERANCE_MM), ROW_MAX);
    add_missing(t, (uint64_t)passes, t->last_pass + 1, 0);
}

void btg_track_close(btg_track *track) {
    if (track->file) fclose(track->file);
    track->file = NULL;
}
