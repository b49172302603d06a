#include "app/app.h"
#include "io/output.h"

#include <string.h>

static const char general[] =
    "bitangent: two-contact, gouge-free positions of a milling cutter on freeform parts\n"
    "\n"
    "  bitangent path PART [-o FILE]...   tool path over PART\n"
    "  bitangent report PART [-o FILE]    the same with a page to look at it, report.html\n"
    "  bitangent verify PART PATH         what PATH leaves of a stock, against PART\n"
    "  bitangent view PART [PATH]         looks at them: a window, or one picture\n"
    "  bitangent bench [PART]...          how fast it is, on this machine\n"
    "  bitangent plan PART                how finely to sample for a tolerance\n"
    "  bitangent info [--json]            version and back ends\n"
    "  bitangent help [COMMAND]           this text, or that of a command\n"
    "  bitangent --version\n"
    "\n"
    "Exit status: 0 done, 1 the work failed, 2 the command line or an input is unusable.\n";

static const char path[] =
    "bitangent path PART [-o FILE]...\n"
    "\n"
    "Places the tool over PART, a glTF file (.gltf, .glb): dropped onto each footprint point, "
    "then\n"
    "tilted until it touches a second time. Millimetres and degrees, z up.\n"
    "\n"
    "  -o, --output FILE       .csv, .json, .cl (APT), .png, .glb (model: part, path, contacts,\n"
    "                          tool), .html (a report) or .ngc (a program for --machine);\n"
    "                          repeat for more. KIND:FILE names the kind where the ending does\n"
    "                          not: csv:-\n"
    "tool\n"
    "  --tool RO,RI[,PROFILE]  major and minor radius; toroidal (round inserts, hollow) or\n"
    "                          bullnose (solid); default 6.7,6,toroidal\n"
    "  --shank R,FROM,TO       cylinder that must not collide, heights over the torus centre\n"
    "  --holder R,FROM,TO      the same, up to 8 of them\n"
    "footprint, over the part's extent in x and y\n"
    "  --footprint KIND        parallel (default): passes along y; zigzag: every second one back;\n"
    "                          one-way[:LIFT]: with a retract at both ends, the tool LIFT mm\n"
    "                          (default 20) over the part's top; contour: along the part's\n"
    "                          outline, then ever farther inside; points:FILE: two columns, x y\n"
    "  --side-step MM          between passes, default 18; scallop: the widest that leaves no "
    "more\n"
    "                          than --scallop between them\n"
    "  --forward-step MM       along a pass, default 2\n"
    "  --overrun MM            the footprint reaches that far beyond the part's extent, default 0\n"
    "solving\n"
    "  --method NAME           vcrf (default), exact: vertical and circular rays; for\n"
    "                          comparison: vcrf-grid, depth, dst, drd, sr, direct, bisection;\n"
    "                          the last four reconstructed from what papers say of them\n"
    "  --ray-spacing MM        vcrf-grid, sr: between rays on the part, default 0.1\n"
    "  --levels 1|2            vcrf-grid, sr, depth, back end osmesa: 2 (default), a second grid\n"
    "                          or window around the best ray or pixel\n"
    "  --window PIXELS         back end osmesa: side of a depth image, default 50, on one level\n"
    "                          625; depth on another: rays in its place, default exact drops\n"
    "  --backend NAME          auto (default), one that is ready, or NAME,auto: others stand in\n"
    "  --raw                   a device's answers in single precision, not polished, not proven\n"
    "  --gl-context NAME       for gl, osmesa: osmesa or egl, default auto\n"
    "  --spin POLICY           turn about the normal at the first contact: none (default),\n"
    "                          fixed:DEG; gap:MM, contacts that far apart; across, at right\n"
    "                          angles to the feed; widest, the widest strip inside the scallop\n"
    "  --scallop MM            what may stay on the part, default 0.01; for widest and\n"
    "                          --side-step scallop\n"
    "  --feed-direction DEG    for across and widest: from x toward y; default 90, along passes\n"
    "  --max-tilt DEG          0 to 90, default 45; machine: as far as --machine's limits let the\n"
    "                          tool lean every way\n"
    "  --chord-tolerance MM    positions are inserted until the moving tool, between them too, is\n"
    "                          nowhere deeper in the part than this; default: not looked at\n"
    "  --max-axis-change D     degrees the axis may turn per mm of footprint; positions lean less\n"
    "                          where they must, and lose their second contact; default: any\n"
    "  --tolerance MM          error allowed in height and clearance, default 0.001\n"
    "  --node-budget N         most nodes a search visits, default 1000000; what it ends with is\n"
    "                          safe, and marked budget\n"
    "  --threads N             default: as many as the machine has\n"
    "the part's file\n"
    "  --gltf-unit m|mm        default m\n"
    "  --up y|z                default y: x = X, y = -Z, z = Y\n"
    "  --use-mesh              ignore exact surfaces, take the triangles\n";

/* A string of C11 ends at 4095 characters. */
static const char path_output[] =
    "output\n"
    "  --feed MM_PER_MIN       for .cl and .ngc, default 1000\n"
    "  --machine NAME|FILE     for .ngc: xyzac-trt or xyzbc-trt (LinuxCNC's), fanuc, siemens,\n"
    "                          heidenhain, or a JSON file; see the README\n"
    "  --tool-length MM        nose of the spindle to tip, default 100 or as FILE says\n"
    "  --tool-number N         default 1\n"
    "  --spindle RPM           default 3000\n"
    "  --motion-tolerance MM   of the machine's motion between positions, default 0.002\n"
    "  --json                  one JSON object on the standard output instead of the table\n"
    "  --quiet                 no progress and no table\n"
    "\n"
    "The .cl and .ngc files retract between passes (not in a zigzag) and where the tool touches "
    "nothing.\n";

static const char verify[] =
    "bitangent verify PART PATH\n"
    "\n"
    "Cuts PATH (.csv as 'bitangent path' writes it, .cl, APT, or .ngc, a program, as its machine\n"
    "moves) into a stock, with the tool as it moves between the positions, and compares what is\n"
    "left with PART, a glTF file. Exit status 1 when a limit is broken, the path's numbers skip a\n"
    "position, or a joint is too fast or beyond its limits.\n"
    "\n"
    "  --max-gouge MM          fail when any cell is cut deeper into the part\n"
    "  --max-scallop MM        fail when more is left on any cell\n"
    "  --grid MM               side of the field's cells, default 0.1 (more on large parts)\n"
    "  --sweep-error MM        error allowed in the shape of the swept tool, default 0.001\n"
    "  --stock MM              top of the block over the part's highest point, default 5\n"
    "  --links pass|all        .csv: the tool moves within a pass (default), or from pass to\n"
    "                          pass too, as in a zigzag\n"
    "  --machine NAME|FILE     for .ngc: as for 'bitangent path'; with --tool-length too\n"
    "  -o, --output FILE       .csv (every cell), .png or .glb; repeat for more\n"
    "  --tool RO,RI[,PROFILE]  default 6.7,6,toroidal, or as the .cl file's CUTTER/ says\n"
    "  --shank R,FROM,TO, --holder R,FROM,TO\n"
    "                          are checked for collision, at the positions and between them\n"
    "  --threads N, --gltf-unit m|mm, --up y|z, --use-mesh, --json, --quiet\n"
    "                          as in 'bitangent help path'\n";

static const char view[] =
    "bitangent view PART [PATH]\n"
    "\n"
    "Shows PART, a glTF file, and the tool on its way along PATH (.csv, .cl, or .ngc with "
    "--machine),\n"
    "or along the path that 'bitangent path' would make: contacts P and Q, the tilt, and what\n"
    "gouges or is left.\n"
    "\n"
    "  --screenshot FILE.png   one picture, without a window or a display\n"
    "  --size WIDTHxHEIGHT     pixels, default 1280x800\n"
    "  --position N            from 1; default: one with much tilt and contacts apart\n"
    "  --view-from SIDE        tilt (default: along the axis about which the tool tilted), iso,\n"
    "                          top, front, back, left, right, or AZIMUTH,ELEVATION in degrees\n"
    "  --look-at tool|part     the tool's surroundings (default), or all of the part\n"
    "  --keys KEY,...          pressed one after another before the picture, or one a frame in "
    "the\n"
    "                          window: space, left, right, shift+left, shift+right, up, down,\n"
    "                          home, end, plus, minus, tab, escape, letters and figures as the\n"
    "                          window's help names them; drop:FILE: a part or a path, as if\n"
    "                          dropped on the window; wait: none\n"
    "  --json                  at the end, one JSON object: position, its angles, frames, pixels "
    "of P\n"
    "                          and Q\n"
    "  --tool, --shank, --holder, --footprint, --side-step, --forward-step, --method, --backend,\n"
    "  --spin, --scallop, --max-tilt, --tolerance, --threads, --gltf-unit, --up, --use-mesh, ...\n"
    "                          as in 'bitangent help path'\n";

static const char report[] =
    "bitangent report PART [-o FILE.html] [-o FILE]...\n"
    "\n"
    "Makes a tool path over PART as 'bitangent path' does, with all of its options (among them\n"
    "--side-step, --tool and --spin), and a page to look at it with any browser, by default\n"
    "report.html: the path in 3D, statuses, tilts, distances of the contacts, gouge and scallop,\n"
    "what every back end makes of it and, with --machine, the joints over time. Everything is\n"
    "inside the page. At most 200000 positions.\n"
    "\n"
    "  -o, --output FILE       .html; others as in 'bitangent help path'\n"
    "  --scallop MM            counts as finished, default 0.01\n"
    "  --machine NAME|FILE     whose joints are shown\n";

static const char bench[] =
    "bitangent bench [PART]...\n"
    "\n"
    "Measures speed on the papers' three surfaces, exact and as triangles, or on PART, a glTF\n"
    "file. Every answer is checked first, against another method: a wrong one gets no figure,\n"
    "and exit status 1.\n"
    "\n"
    "  --speed                 what is done when nothing else is asked for\n"
    "  --backends              all back ends on the same five-axis positions, some hundred of the\n"
    "                          papers' concave surface and a large batch: speed, where the time\n"
    "                          goes, errors before and after the polish, memory\n"
    "  --papers                the papers' tables and figures made again, beside theirs "
    "(minutes);\n"
    "                          with --quick fewer positions\n"
    "  --pictures FOLDER       their figures there, PNG and SVG\n"
    "  --only MEASURE,...      some of: speed, latency, triangles, degree, threads, tolerance,\n"
    "                          path, spin, backends; triangles and degree have parts of their own\n"
    "  --quick                 a few seconds: fewer parts, shorter runs\n"
    "  --seconds S             about how long all of it may take; default 50, --quick 3.\n"
    "                          Latencies are taken from 1000000 positions at most\n"
    "  --points FILE           places for the tool over PART, two columns, x y in mm;\n"
    "                          default: spread over the part\n"
    "  --tolerance MM          default 1e-6\n"
    "  --tool, --max-tilt, --node-budget, --gltf-unit, --up, --use-mesh\n"
    "                          as in 'bitangent help path'\n"
    "output\n"
    "  --csv FILE              a row a measurement, with the machine's name; '-': stdout\n"
    "  -o, --output FILE.png   a picture of the back ends\n"
    "  --commit NAME           what was measured, for the CSV\n"
    "  --json                  one JSON object on the standard output instead of the tables\n"
    "  --quiet                 no progress and no tables\n";

static const char plan[] =
    "bitangent plan PART\n"
    "\n"
    "How finely to sample for a tolerance: pixels and levels of a drop by depth images, facets of\n"
    "tool and part, after the GPU paper's error model; then drops by such pixels on PART, a glTF\n"
    "file, against exact ones: by the back end osmesa where it is ready, else by a ray a pixel.\n"
    "Exit status 1 when an error is above its bound, or all are below a tenth of theirs, or the\n"
    "tolerance is not kept.\n"
    "\n"
    "  --tolerance MM          default 0.001\n"
    "  -o, --output FILE       .png or .svg: error against pixels\n"
    "  --tool RO,RI[,PROFILE], --gltf-unit m|mm, --up y|z, --use-mesh, --json, --quiet\n"
    "                          as in 'bitangent help path'\n";

static const char info[] =
    "bitangent info [--json]\n"
    "\n"
    "Version, and the back ends: not built, built but without a device, or ready.\n";

int app_help(const char *topic) {
    const char *text = general, *more = "";
    btg_message message;
    if (topic && strcmp(topic, "path") == 0) {
        text = path;
        more = path_output;
    } else if (topic && strcmp(topic, "verify") == 0) {
        text = verify;
    } else if (topic && strcmp(topic, "view") == 0) {
        text = view;
    } else if (topic && strcmp(topic, "report") == 0) {
        text = report;
    } else if (topic && strcmp(topic, "bench") == 0) {
        text = bench;
    } else if (topic && strcmp(topic, "plan") == 0) {
        text = plan;
    } else if (topic && strcmp(topic, "info") == 0) {
        text = info;
    } else if (topic && strcmp(topic, "help") != 0) {
        return app_complain(APP_UNUSABLE,
                            "no help on '%.200s'; there is path, report, verify, view, bench, "
                            "plan and info",
                            topic);
    }
    btg_output out = btg_output_borrow(stdout);
    btg_output_text(&out, text);
    btg_output_text(&out, more);
    if (btg_output_finish(&out, &message) == BTG_OK) return APP_DONE;
    return app_complain(APP_FAILED, "%s", message.text);
}
