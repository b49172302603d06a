/* CSV, JSON and APT, byte for byte. */
#include "bitangent/post.h"
#include "check.h"
#include "core/vec.h"
#include "io/csv.h"
#include "io/json.h"

#include <stdlib.h>
#include <string.h>

/* ---- CSV and JSON ------------------------------------------------------------------------- */

static char *text_of(FILE *file) {
    long size = ftell(file);
    char *text = calloc(1, (size_t)size + 1);
    rewind(file);
    CHECK(text && fread(text, 1, (size_t)size, file) == (size_t)size);
    fclose(file);
    return text;
}

static btg_row example(void) {
    btg_row row = {.number = 159, .pass = 3, .point = 14};
    btg_position *p = &row.position;
    p->status = BTG_SINGLE_CONTACT;
    p->foot_x_mm = 0.1;
    p->foot_y_mm = -2;
    p->tip = vec(1, 2, 1.0 / 3);
    p->axis = vec(0, 0, 1);
    p->p.point = vec(1e-300, 1e15, 0);
    p->p.normal = vec(0, 0, 1);
    p->q.point = p->q.normal = vec(NAN, -NAN, NAN);
    p->drop_z_mm = 7;
    p->tilt_rad = BTG_PI / 2;
    return row;
}

static void test_csv(void) {
    FILE *file = tmpfile();
    btg_output out = btg_output_borrow(file);
    btg_row row = example();
    btg_csv_header(&out, true);
    btg_csv_row(&out, &row);
    row.lift = true;
    btg_csv_row(&out, &row);
    char *text = text_of(file);
    CHECK(strcmp(text,
                 "pass,point,status,foot_x,foot_y,tip_x,tip_y,tip_z,axis_x,axis_y,axis_z,p_x,p_y,"
                 "p_z,np_x,np_y,np_z,q_x,q_y,q_z,nq_x,nq_y,nq_z,drop_z,tilt_deg,spin_deg,"
                 "inclination_deg,row\n"
                 "3,14,single-contact,0.10000000000000001,-2,1,2,0.33333333333333331,0,0,1,"
                 "1e-300,1000000000000000,0,0,0,1,nan,nan,nan,nan,nan,nan,7,90,0,"
                 "0,159\n"
                 "3,14,lift,0.10000000000000001,-2,1,2,0.33333333333333331,0,0,1,nan,nan,nan,nan,"
                 "nan,nan,nan,nan,nan,nan,nan,nan,nan,nan,nan,nan,159\n") == 0);
    free(text);
}

static void test_json(void) {
    FILE *file = tmpfile();
    btg_output out = btg_output_borrow(file);
    btg_json json = btg_json_to(&out);
    btg_json_open(&json, NULL, '{');
    btg_json_string(&json, "a\"\\\n", "\x01\x7f t\xc3\xa9 \xff\xc3 \xed\xa0\x80");
    btg_json_open(&json, "l", '[');
    btg_json_number(&json, NULL, 0.1);
    btg_json_number(&json, NULL, 1.0 / 3);
    btg_json_number(&json, NULL, NAN);
    btg_json_number(&json, NULL, INFINITY);
    btg_json_close(&json, ']');
    btg_json_open(&json, "e", '[');
    btg_json_close(&json, ']');
    btg_json_count(&json, "n", UINT64_MAX);
    btg_json_bool(&json, "b", true);
    btg_json_close(&json, '}');
    char *text = text_of(file);
    const char *mend = "\xef\xbf\xbd";
    char expected[400];
    snprintf(expected, sizeof expected,
             "{\"a\\\"\\\\\\u000a\":\"\\u0001\\u007f t\xc3\xa9 %s%s %s%s%s\",\"l\":[0.1,"
             "0.33333333333333331,null,null],\"e\":[],\"n\":18446744073709551615,\"b\":true}",
             mend, mend, mend, mend, mend);
    CHECK(strcmp(text, expected) == 0);
    free(text);
}

/* ---- APT ---------------------------------------------------------------------------------- */

typedef struct memory {
    char text[4096];
    size_t size, room;
} memory;

static btg_status keep(const char *text, size_t size, void *user) {
    memory *m = user;
    if (size > m->room - m->size) return BTG_ERROR_FILE;
    memcpy(m->text + m->size, text, size);
    m->size += size;
    m->text[m->size] = '\0';
    return BTG_OK;
}

static btg_tool plain_tool(void) {
    btg_tool_def def = btg_tool_def_default();
    btg_tool tool;
    def.shank = (btg_cylinder){5, 10, 50};
    CHECK(btg_tool_init(&def, &tool, NULL) == BTG_OK);
    return tool;
}

static btg_position at(double x, double y, double z) {
    btg_position p = {.tip = {x, y, z}, .axis = {0, 0, 1}};
    return p;
}

static void test_apt(void) {
    memory m = {.room = sizeof m.text - 1};
    btg_apt apt;
    btg_tool tool = plain_tool();
    btg_apt_def def = btg_apt_def_default();
    def.part_name = "part $1\n";
    def.clear_z_mm = 30;
    def.write = keep;
    def.user = &m;
    CHECK(btg_apt_begin(&apt, &def, &tool, NULL) == BTG_OK);
    btg_position a = at(0, -1e-9, 1), b = at(1, 2, 1e-7), none = {.status = BTG_NO_CONTACT};
    btg_position far = at(-123456.7890125, 123456.5, -0.1);
    CHECK(btg_apt_add(&apt, &none, 1) == BTG_OK);
    CHECK(btg_apt_add(&apt, &a, 1) == BTG_OK);
    CHECK(btg_apt_add(&apt, &b, 1) == BTG_OK);
    CHECK(btg_apt_add(&apt, &none, 1) == BTG_OK);
    CHECK(btg_apt_add(&apt, &far, 1) == BTG_OK);
    CHECK(btg_apt_end(&apt) == BTG_OK);
    CHECK(strcmp(m.text,
                 "PARTNO part  1 \nUNITS/MM\nMULTAX/ON\n"
                 "CUTTER/25.400000,6.000000,6.700000,6.000000,0.000000,0.000000,56.000000\nFEDRAT/"
                 "1000.000000,MMPM\n"
                 "RAPID\n"
                 "GOTO/0.000000,0.000000,30.000000,0.000000000,0.000000000,1.000000000\n"
                 "GOTO/0.000000,0.000000,1.000000,0.000000000,0.000000000,1.000000000\n"
                 "GOTO/1.000000,2.000000,0.000000,0.000000000,0.000000000,1.000000000\n"
                 "RAPID\n"
                 "GOTO/1.000000,2.000000,30.000000,0.000000000,0.000000000,1.000000000\n"
                 "RAPID\n"
                 "GOTO/-123456.789013,123456.500000,30.000000,0.000000000,0.000000000,$\n"
                 "1.000000000\n"
                 "GOTO/-123456.789013,123456.500000,-0.100000,0.000000000,0.000000000,$\n"
                 "1.000000000\n"
                 "RAPID\n"
                 "GOTO/-123456.789013,123456.500000,30.000000,0.000000000,0.000000000,$\n"
                 "1.000000000\n"
                 "PPRINT MOVES 7\n"
                 "FINI\n") == 0);
}

/* Numbers of all lengths: no line reaches column 72, and some come next to it. */
static void test_apt_lines(void) {
    memory m = {.room = sizeof m.text - 1};
    btg_apt apt;
    btg_tool tool = plain_tool();
    btg_apt_def def = btg_apt_def_default();
    def.clear_z_mm = 30;
    def.write = keep;
    def.user = &m;
    CHECK(btg_apt_begin(&apt, &def, &tool, NULL) == BTG_OK);
    size_t longest = 0;
    for (int i = 0; i < 64; i++) {
        const double size[4] = {1, 100, -1e6, 10};
        btg_position p = at(size[i % 4], size[i / 4 % 4], size[i / 16]);
        m.size = 0;
        CHECK(btg_apt_add(&apt, &p, i > 0) == BTG_OK);
        for (const char *line = m.text; *line; line += strcspn(line, "\n") + 1) {
            size_t length = strcspn(line, "\n");
            if (length > longest) longest = length;
        }
    }
    CHECK(longest == 71);
}

static void test_apt_errors(void) {
    memory m = {.room = 300};
    btg_apt apt;
    btg_tool tool = plain_tool();
    btg_apt_def def = btg_apt_def_default();
    CHECK(btg_apt_begin(&apt, &def, &tool, NULL) == BTG_ERROR_ARGUMENT);
    def.write = keep;
    def.user = &m;
    CHECK(btg_apt_begin(&apt, &def, &tool, NULL) == BTG_ERROR_ARGUMENT);
    def.clear_z_mm = 1;
    def.feed_mm_per_min = 0;
    CHECK(btg_apt_begin(&apt, &def, &tool, NULL) == BTG_ERROR_ARGUMENT);
    def.feed_mm_per_min = 1;
    CHECK(btg_apt_begin(&apt, &def, &tool, NULL) == BTG_OK);
    btg_position bad = at(0, 0, NAN), good = at(0, 0, 0);
    CHECK(btg_apt_add(&apt, &bad, 1) == BTG_ERROR_ARGUMENT);
    btg_status status = BTG_OK;
    for (int i = 0; i < 10 && status == BTG_OK; i++)
        status = btg_apt_add(&apt, &good, 1);
    CHECK(status == BTG_ERROR_FILE);
}

/* The lowest point of the leaning tool, sampled, stands exactly at the height asked. */
static void test_lift(void) {
    btg_tool tool = plain_tool();
    CHECK(btg_post_lift_z(&tool, vec(0, 0, 1), 30) == 30);
    for (double lean = 0.1; lean < 1.5; lean += 0.2) {
        btg_vec3 axis = vec(sin(lean), 0, cos(lean)), side = vec(-cos(lean), 0, sin(lean));
        double z = btg_post_lift_z(&tool, axis, 30), lowest = INFINITY;
        btg_vec3 centre = vec_mad(vec(0, 0, z), axis, tool.def.minor_radius_mm);
        for (uint32_t i = 0; i < tool.element_count; i++) {
            const btg_tool_element *e = &tool.element[i];
            btg_vec3 rim = vec_mad(centre, axis, e->from_mm);
            rim = vec_mad(rim, side, -e->ring_radius_mm);
            lowest = fmin(lowest, rim.z - e->corner_radius_mm);
        }
        CHECK(fabs(lowest - 30) < 1e-9);
    }
}

int main(void) {
    test_csv();
    test_json();
    test_apt();
    test_apt_lines();
    test_apt_errors();
    test_lift();
    return check_result();
}
