#include "app/app.h"
#include "app/terminal.h"
#include "bitangent/backend.h"
#include "io/json.h"

#include <string.h>

static void print_table(FILE *file) {
    static const char *const word[3] = {"not built", "built, no device", "ready"};
    fprintf(file, "bitangent %s\n\n", btg_version());
    fprintf(file, "%-10s %-17s %s\n", "back end", "state", "what it is");
    for (size_t i = 0; i < btg_backend_count(); i++) {
        btg_backend_info info;
        if (btg_backend_get_info(i, &info) != BTG_OK) continue;
        fprintf(file, "%-10s %-17s %s", info.name, word[info.state], info.summary);
        fprintf(file, info.device[0] ? " (%s)\n" : "\n", info.device);
    }
}

static void print_json(btg_output *out) {
    btg_json json = btg_json_to(out);
    btg_json_open(&json, NULL, '{');
    btg_json_string(&json, "version", btg_version());
    btg_json_open(&json, "backends", '[');
    for (size_t i = 0; i < btg_backend_count(); i++) {
        btg_backend_info info;
        if (btg_backend_get_info(i, &info) != BTG_OK) continue;
        btg_json_open(&json, NULL, '{');
        btg_json_string(&json, "name", info.name);
        btg_json_string(&json, "state", btg_backend_state_name(info.state));
        btg_json_string(&json, "device", info.device);
        btg_json_string(&json, "summary", info.summary);
        btg_json_close(&json, '}');
    }
    btg_json_close(&json, ']');
    btg_json_close(&json, '}');
    btg_output_text(out, "\n");
}

int app_info(int count, char **words) {
    bool json = false;
    for (int i = 0; i < count; i++) {
        if (strcmp(words[i], "--help") == 0 || strcmp(words[i], "-h") == 0) return app_help("info");
        if (strcmp(words[i], "--json") != 0) {
            return app_complain(APP_UNUSABLE, "info: unknown '%.200s'; it takes --json alone",
                                words[i]);
        }
        json = true;
    }
    btg_message message;
    btg_output out = btg_output_borrow(stdout);
    if (json) {
        print_json(&out);
    } else {
        terminal table;
        terminal_open(&table, stdout);
        print_table(table.file);
        terminal_close(&table);
    }
    if (btg_output_finish(&out, &message) == BTG_OK) return APP_DONE;
    return app_complain(APP_FAILED, "%s", message.text);
}
