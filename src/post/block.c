/* A line of a program as words. Numbers are read by hand: strtod follows the locale and takes
 * exponents, which controls do not. */
#include "core/part.h"
#include "post/read.h"

#include <ctype.h>
#include <string.h>

/* Digits that a double holds without rounding, so that a number is rounded once. */
#define DIGITS_MAX 15
/* Largest word, and longest name. */
#define NUMBER_MAX 1e8
#define NAME_MAX   16

typedef struct cursor {
    btg_control control;
    const char *at;
    btg_block *block;
    btg_message *message;
} cursor;

static btg_status refuse(const cursor *c, const char *word, size_t size, const char *reason) {
    char shown[24];
    if (size > sizeof shown - 1) size = sizeof shown - 1;
    for (size_t i = 0; i < size; i++)
        shown[i] = isprint((unsigned char)word[i]) ? word[i] : '?';
    shown[size] = '\0';
    return btg_fail(c->message, BTG_ERROR_FORMAT, "'%s': %s", shown, reason);
}

static btg_status not_understood(const cursor *c, const char *word, size_t size) {
    return refuse(c, word, size,
                  "not understood; give straight moves in absolute millimetres, as 'bitangent "
                  "path' writes them");
}

static void skip_blanks(cursor *c) {
    while (*c->at == ' ' || *c->at == '\t')
        c->at++;
}

static bool read_number(cursor *c, double *value) {
    static const double scale[DIGITS_MAX + 1] = {1,   1e1, 1e2,  1e3,  1e4,  1e5,  1e6,  1e7,
                                                 1e8, 1e9, 1e10, 1e11, 1e12, 1e13, 1e14, 1e15};
    const char *s = c->at;
    bool minus = *s == '-';
    if (*s == '-' || *s == '+') s++;
    double sum = 0;
    int digits = 0, seen = 0, decimals = 0;
    for (bool point = false; isdigit((unsigned char)*s) || (*s == '.' && !point); s++) {
        if (*s == '.') {
            point = true;
            continue;
        }
        seen++;
        if (sum > 0 || *s != '0') digits++;
        if (digits > DIGITS_MAX) return false;
        sum = sum * 10 + (*s - '0');
        if (point && ++decimals > DIGITS_MAX) return false;
    }
    if (seen == 0) return false;
    sum /= scale[decimals];
    if (sum > NUMBER_MAX) return false;
    c->at = s;
    *value = minus ? -sum : sum;
    return true;
}

/* ---- words -------------------------------------------------------------------------------- */

static btg_status take_code(cursor *c, const char *word, double value) {
    bool is_g = *word == 'G' || *word == 'g';
    int *codes = is_g ? c->block->g : c->block->m,
        *count = is_g ? &c->block->g_count : &c->block->m_count;
    double code = is_g ? value * 10 : value;
    size_t size = (size_t)(c->at - word);
    if (!(code >= 0 && code < 100000) || fabs(code - floor(code + 0.5)) > 1e-6)
        return not_understood(c, word, size);
    if (*count == BTG_BLOCK_CODES) return refuse(c, word, size, "too many in one line; split it");
    codes[(*count)++] = (int)floor(code + 0.5);
    return BTG_OK;
}

/* A3=0.5 */
static btg_status take_vector(cursor *c, const char *word, int i) {
    double value;
    c->at = word + 3;
    if (!read_number(c, &value)) return refuse(c, word, 8, "no number; give a decimal one");
    if (c->block->has_vector[i]) return refuse(c, word, 3, "twice in one line; give it once");
    c->block->has_vector[i] = true;
    c->block->vector[i] = value;
    return BTG_OK;
}

static btg_status take_letter(cursor *c, const char *word) {
    int i = toupper((unsigned char)*word) - 'A';
    double value;
    if (c->control == BTG_CONTROL_SIEMENS && i < 3 && word[1] == '3' && word[2] == '=')
        return take_vector(c, word, i);
    if (c->control == BTG_CONTROL_HEIDENHAIN && i == 'L' - 'A') {
        c->block->keywords |= BTG_KEYWORD_L;
        return BTG_OK;
    }
    skip_blanks(c);
    if (!read_number(c, &value))
        return refuse(c, word, strcspn(word, " \t"),
                      "no decimal number of up to 15 digits follows; give one");
    if (i == 'G' - 'A' || i == 'M' - 'A') return take_code(c, word, value);
    if (c->block->has[i])
        return refuse(c, word, (size_t)(c->at - word), "twice in one line; give it once");
    c->block->has[i] = true;
    c->block->value[i] = value;
    return BTG_OK;
}

static btg_status take_name(cursor *c, const char *word, size_t size) {
    static const struct {
        const char *name;
        btg_control control;
        btg_keyword keyword;
    } known[] = {
        {"SUPA", BTG_CONTROL_SIEMENS, BTG_KEYWORD_SUPA},
        {"TRAORI", BTG_CONTROL_SIEMENS, BTG_KEYWORD_TRAORI},
        {"TRAFOOF", BTG_CONTROL_SIEMENS, BTG_KEYWORD_TRAFOOF},
        {"ORIWKS", BTG_CONTROL_SIEMENS, BTG_KEYWORD_ORIWKS},
        {"ORIVECT", BTG_CONTROL_SIEMENS, BTG_KEYWORD_ORIVECT},
        {"ORIAXES", BTG_CONTROL_SIEMENS, BTG_KEYWORD_ORIAXES},
        {"FMAX", BTG_CONTROL_HEIDENHAIN, BTG_KEYWORD_FMAX},
        {"FT", BTG_CONTROL_HEIDENHAIN, BTG_KEYWORD_FT},
    };
    char name[NAME_MAX] = "";
    for (size_t i = 0; i < size && size < sizeof name; i++)
        name[i] = (char)toupper((unsigned char)word[i]);
    for (size_t i = 0; i < sizeof known / sizeof *known; i++) {
        if (known[i].control != c->control || strcmp(known[i].name, name) != 0) continue;
        c->block->keywords |= known[i].keyword;
        if (known[i].keyword == BTG_KEYWORD_FT && !read_number(c, &c->block->seconds))
            return refuse(c, word, size, "no number of seconds follows; give one");
        return BTG_OK;
    }
    return not_understood(c, word, size);
}

/* ---- comments and what stands at a line's beginning ------------------------------------------ */

static void take_comment(cursor *c, const char *text) {
    if (strncmp(text, "BITANGENT ", 10) == 0) c->block->counted = true;
    if (strncmp(text, "MOVES ", 6) != 0) return;
    cursor inner = {.at = text + 6};
    double value;
    if (read_number(&inner, &value) && value >= 0) c->block->promised[0] = (long)value;
    if (strncmp(inner.at, " OF ", 4) != 0) return;
    inner.at += 4;
    if (read_number(&inner, &value) && value >= 0) c->block->promised[1] = (long)value;
}

static btg_status skip_comment(cursor *c) {
    bool round = *c->at == '(';
    c->at += 1 + strspn(c->at + 1, round ? "" : " ");
    take_comment(c, c->at);
    if (!round) {
        c->at += strlen(c->at);
        return BTG_OK;
    }
    c->at += strcspn(c->at, ")");
    if (*c->at == '\0') return refuse(c, "(", 1, "the comment does not end; close it with )");
    c->at++;
    return BTG_OK;
}

static bool begins(cursor *c, const char *word) {
    size_t size = strlen(word);
    if (strncmp(c->at, word, size) != 0) return false;
    c->at += size;
    return true;
}

/* Heidenhain's lines that are no words: the rest of them in c->at. */
static btg_status take_heading(cursor *c) {
    double value;
    if (isdigit((unsigned char)*c->at) && !read_number(c, &value))
        return refuse(c, c->at, 16, "no block number; give up to 8 digits");
    skip_blanks(c);
    bool begin = begins(c, "BEGIN PGM "), end = !begin && begins(c, "END PGM ");
    if (begin || end) {
        size_t size = strlen(c->at);
        while (size > 0 && isspace((unsigned char)c->at[size - 1]))
            size--;
        if (size < 3 || strncmp(c->at + size - 3, " MM", 3) != 0)
            return refuse(c, c->at, size, "the program is not in MM; give millimetres");
        c->block->keywords |= begin ? BTG_KEYWORD_BEGIN : BTG_KEYWORD_END;
        c->at += strlen(c->at);
        return BTG_OK;
    }
    if (!begins(c, "TOOL CALL ")) return BTG_OK;
    skip_blanks(c);
    if (!read_number(c, &value) || value < 0)
        return refuse(c, "TOOL CALL", 9, "no tool number follows; give one");
    skip_blanks(c);
    if (!begins(c, "Z")) return refuse(c, "TOOL CALL", 9, "the tool's axis is not Z; give Z");
    c->block->keywords |= BTG_KEYWORD_TOOL;
    c->block->tool = (long)value;
    return BTG_OK;
}

btg_status btg_block_parse(btg_control control, const char *text, btg_block *block,
                           btg_message *message) {
    memset(block, 0, sizeof *block);
    block->promised[0] = block->promised[1] = -1;
    cursor c = {control, text, block, message};
    btg_status status = BTG_OK;
    skip_blanks(&c);
    bool round = control == BTG_CONTROL_LINUXCNC || control == BTG_CONTROL_FANUC;
    if (round && *c.at == '%') c.at++;
    if (control == BTG_CONTROL_HEIDENHAIN) status = take_heading(&c);
    block->any = block->keywords != 0;
    while (status == BTG_OK) {
        skip_blanks(&c);
        if (*c.at == '\0') break;
        const char *word = c.at;
        if (*word == ';' || (round && *word == '(')) {
            status = skip_comment(&c);
            continue;
        }
        block->any = true;
        size_t size = 0;
        while (isalpha((unsigned char)word[size]))
            size++;
        c.at += size;
        if (size == 0) status = not_understood(&c, word, strcspn(word, " \t"));
        if (size == 1) status = take_letter(&c, word);
        if (size > 1) status = take_name(&c, word, size);
    }
    return status;
}
