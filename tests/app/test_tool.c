#include "bitangent/bitangent.h"
#include "check.h"
#include "core/part.h"

#include <string.h>

static void test_elements(void) {
    btg_tool tool;
    btg_message message;
    btg_tool_def def = btg_tool_def_default();
    CHECK(btg_tool_init(&def, &tool, &message) == BTG_OK);
    CHECK(tool.element_count == 1);
    CHECK(tool.element[0].ring_radius_mm == 6.7 && tool.element[0].corner_radius_mm == 6);
    CHECK(tool.element[0].from_mm == 0 && isinf(tool.element[0].to_mm));
    CHECK(tool.element[0].hollow == 1);

    def.profile = BTG_PROFILE_BULLNOSE;
    def.minor_radius_mm = 0;
    def.shank = (btg_cylinder){5, 10, 40};
    def.holder[0] = (btg_cylinder){20, 40, 60};
    def.holder[1] = (btg_cylinder){30, 60, 61};
    def.holder_count = 2;
    CHECK(btg_tool_init(&def, &tool, &message) == BTG_OK);
    CHECK(tool.element_count == 4 && tool.element[0].hollow == 0);
    CHECK(tool.element[1].ring_radius_mm == 5 && tool.element[1].from_mm == 10);
    CHECK(tool.element[1].corner_radius_mm == 0 && tool.element[1].hollow == 0);
    CHECK(tool.element[3].ring_radius_mm == 30 && tool.element[3].to_mm == 61);

    def = btg_tool_def_default();
    def.major_radius_mm = 0;
    CHECK(btg_tool_init(&def, &tool, &message) == BTG_OK);
    CHECK(tool.element[0].hollow == 0);
}

static void refused(btg_tool_def def, const char *word) {
    btg_tool tool;
    btg_message message = {""};
    memset(&tool, 0x5a, sizeof tool);
    CHECK(btg_tool_init(&def, &tool, &message) == BTG_ERROR_ARGUMENT);
    CHECK(strstr(message.text, word) != NULL && !strchr(message.text, '\n'));
    CHECK(btg_tool_init(&def, &tool, NULL) == BTG_ERROR_ARGUMENT);
    const unsigned char *byte = (const unsigned char *)&tool;
    for (size_t i = 0; i < sizeof tool; i++)
        CHECK(byte[i] == 0x5a);
}

static void test_radii(void) {
    const double bad[] = {-1, NAN, INFINITY, 1.1e6};
    for (int i = 0; i < 4; i++) {
        btg_tool_def def = btg_tool_def_default();
        def.major_radius_mm = bad[i];
        refused(def, "major radius");
        def = btg_tool_def_default();
        def.minor_radius_mm = bad[i];
        refused(def, "minor radius");
    }
    btg_tool_def def = btg_tool_def_default();
    def.minor_radius_mm = 0;
    refused(def, "toroidal");
    def.profile = BTG_PROFILE_BULLNOSE;
    def.major_radius_mm = 0;
    refused(def, "both radii");
    def = btg_tool_def_default();
    def.profile = (btg_profile)7;
    refused(def, "profile");
    def = btg_tool_def_default();
    def.version = 0;
    refused(def, "version");
}

static void test_cylinders(void) {
    const btg_cylinder bad[] = {{-1, 0, 1}, {NAN, 0, 1}, {2, -1, 1},      {2, 5, 5},
                                {2, 6, 5},  {2, 0, NAN}, {2, 0, INFINITY}};
    for (int i = 0; i < 7; i++) {
        btg_tool_def def = btg_tool_def_default();
        def.shank = bad[i];
        refused(def, "shank");
        def = btg_tool_def_default();
        def.holder_count = 1;
        def.holder[0] = bad[i];
        refused(def, "holder 1");
    }
    btg_tool_def def = btg_tool_def_default();
    def.holder_count = 1;
    refused(def, "radius is 0");
    def.holder_count = BTG_HOLDER_MAX + 1;
    refused(def, "at most 8");
}

/* Sizes whose product does not fit are refused, none is a valid size. */
static void test_allocation(void) {
    btg_allocator plain = {0};
    CHECK(btg_allocate(&plain, SIZE_MAX / 2, 3) == NULL);
    void *memory = btg_allocate(&plain, 0, 8);
    CHECK(memory != NULL);
    btg_release(&plain, memory);
    btg_release(&plain, NULL);
}

static void test_messages(void) {
    btg_message message;
    CHECK(btg_fail(&message, BTG_ERROR_FILE, "%s", "a\nb\x1b[m") == BTG_ERROR_FILE);
    CHECK(strcmp(message.text, "a?b?[m") == 0);
    char text[2000];
    memset(text, 'x', sizeof text);
    text[sizeof text - 1] = '\0';
    btg_fail(&message, BTG_ERROR_FILE, "%s", text);
    CHECK(strlen(message.text) == sizeof message.text - 1);
    CHECK(strcmp(btg_version(), "0.1.0") == 0);
    CHECK(strcmp(btg_status_name(BTG_OSCULATING), "osculating") == 0);
    CHECK(strcmp(btg_status_name((btg_status)-99), "unknown") == 0);
}

int main(void) {
    test_elements();
    test_radii();
    test_cylinders();
    test_allocation();
    test_messages();
    return check_result();
}
