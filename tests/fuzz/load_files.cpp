// Loads every glTF file under the paths given and holds the loader to its word: it answers, soon,
// with a status and one line. Prints how often each status came. For damaged files, and for
// collections of real ones.
//
//   load_files [--seconds S] [--require-ok] [--verbose] [--skip-missing] PATH...
//
//   --seconds S      longest time for one file, of the processor, default 5
//   --require-ok     every file must load
//   --skip-missing   exit with 77 when a path does not exist
#include "bitangent/gltf.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <ctime>
#include <filesystem>
#include <map>
#include <string>
#include <vector>

namespace fs = std::filesystem;

struct Options {
    double seconds = 5;
    bool require_ok = false, skip_missing = false, verbose = false;
    std::vector<fs::path> paths;
};

struct Tally {
    std::map<std::string, size_t> statuses;
    size_t files = 0, faults = 0;
    double slowest = 0;
    std::string slowest_file;
};

static Options parse(int count, char **words) {
    Options options;
    for (int i = 1; i < count; i++) {
        std::string word = words[i];
        if (word == "--seconds" && i + 1 < count)
            options.seconds = std::atof(words[++i]);
        else if (word == "--require-ok")
            options.require_ok = true;
        else if (word == "--skip-missing")
            options.skip_missing = true;
        else if (word == "--verbose")
            options.verbose = true;
        else
            options.paths.emplace_back(word);
    }
    return options;
}

static bool is_gltf(const fs::path &file) {
    return file.extension() == ".gltf" || file.extension() == ".glb";
}

static std::vector<fs::path> list_files(const std::vector<fs::path> &paths) {
    std::vector<fs::path> files;
    for (const fs::path &path : paths) {
        if (!fs::is_directory(path)) files.push_back(path);
        if (fs::is_directory(path))
            for (const auto &entry : fs::recursive_directory_iterator(path))
                if (entry.is_regular_file() && is_gltf(entry.path())) files.push_back(entry.path());
    }
    std::sort(files.begin(), files.end());
    return files;
}

static void fault(Tally &tally, const fs::path &file, const char *what, const char *text) {
    std::printf("FAIL %s: %s: \"%s\"\n", file.c_str(), what, text);
    tally.faults++;
}

static void check_message(Tally &tally, const fs::path &file, const char *text) {
    if (text[0] == '\0') fault(tally, file, "empty message", text);
    for (const char *c = text; *c; c++)
        if (static_cast<unsigned char>(*c) < 0x20 || *c == 0x7f)
            return fault(tally, file, "control character in the message", text);
    if (std::strstr(text, ": ") == nullptr) fault(tally, file, "message without a place", text);
}

// A part that loads must be a real one: its box finite and no larger than the core allows.
static void check_part(Tally &tally, const fs::path &file, const btg_part *part) {
    btg_part_info info;
    btg_part_get_info(part, &info);
    const double box[] = {info.box_min.x, info.box_min.y, info.box_min.z,
                          info.box_max.x, info.box_max.y, info.box_max.z};
    for (double x : box)
        if (!(std::fabs(x) <= 1.01 * BTG_LENGTH_MAX))
            return fault(tally, file, "box is not finite", "");
    if (info.patch_count + info.triangle_count == 0) fault(tally, file, "empty part", "");
}

static void load(const Options &options, const fs::path &file, Tally &tally) {
    btg_gltf_def def = btg_gltf_def_default();
    btg_part *part = nullptr;
    btg_message message;
    std::memset(message.text, 'x', sizeof message.text);
    std::clock_t start = std::clock();
    btg_status status = btg_gltf_load(file.c_str(), &def, &part, &message);
    double seconds = static_cast<double>(std::clock() - start) / CLOCKS_PER_SEC;
    message.text[sizeof message.text - 1] = '\0';
    tally.files++;
    tally.statuses[status == BTG_OK ? "ok" : btg_status_name(status)]++;
    if (seconds > tally.slowest) tally.slowest = seconds, tally.slowest_file = file.string();
    if (seconds > options.seconds) fault(tally, file, "too slow", message.text);
    if ((status == BTG_OK) != (part != nullptr)) fault(tally, file, "part and status differ", "");
    if (status > 0) fault(tally, file, "status is no answer of a loader", "");
    if (status < 0) check_message(tally, file, message.text);
    if (status != BTG_OK && options.require_ok) fault(tally, file, "must load", message.text);
    if (part) check_part(tally, file, part);
    btg_part_destroy(part);
    if (options.verbose)
        std::printf("%s: %s\n", status == BTG_OK ? "ok" : btg_status_name(status),
                    message.text[0] ? message.text : file.c_str());
}

int main(int count, char **words) {
    Options options = parse(count, words);
    for (const fs::path &path : options.paths)
        if (!fs::exists(path)) {
            std::printf("%s does not exist\n", path.c_str());
            return options.skip_missing ? 77 : 1;
        }
    Tally tally;
    for (const fs::path &file : list_files(options.paths))
        load(options, file, tally);
    for (const auto &[status, number] : tally.statuses)
        std::printf("%8zu %s\n", number, status.c_str());
    std::printf("%8zu files, slowest %.3f s: %s\n", tally.files, tally.slowest,
                tally.slowest_file.c_str());
    return tally.faults > 0 || tally.files == 0;
}
