#include "app/app.h"
#include "io/output.h"

#include <string.h>

static bool is(const char *word, const char *name) {
    return strcmp(word, name) == 0;
}

static int version(void) {
    btg_message message;
    btg_output out = btg_output_borrow(stdout);
    btg_output_format(&out, "bitangent %s\n", btg_version());
    if (btg_output_finish(&out, &message) == BTG_OK) return APP_DONE;
    return app_complain(APP_FAILED, "%s", message.text);
}

int main(int count, char **words) {
    btg_output_guard();
    if (count < 2) {
        return app_complain(APP_UNUSABLE, "no command; give path, report, verify, view, bench, "
                                          "plan or info, see 'bitangent help'");
    }
    const char *command = words[1];
    if (is(command, "path")) return app_path(count - 2, words + 2);
    if (is(command, "verify")) return app_verify(count - 2, words + 2);
    if (is(command, "report")) return app_report(count - 2, words + 2);
    if (is(command, "bench")) return app_bench(count - 2, words + 2);
    if (is(command, "view")) return app_view(count - 2, words + 2);
    if (is(command, "plan")) return app_plan(count - 2, words + 2);
    if (is(command, "info")) return app_info(count - 2, words + 2);
    if (is(command, "help") || is(command, "--help") || is(command, "-h")) {
        return app_help(count > 2 ? words[2] : NULL);
    }
    if (is(command, "--version")) return version();
    return app_complain(APP_UNUSABLE, "unknown command '%.200s'; see 'bitangent help'", command);
}
