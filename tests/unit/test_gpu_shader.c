/* SPDX-License-Identifier: MIT
 *
 * From GLSL to a program: where includes are found, which file and line an error names, defines,
 * what reflection tells the null backend's log, and the disk cache with sound and spoilt entries.
 */
#define _POSIX_C_SOURCE 200809L
#include "unit/gpu_fixture.h"

#include <dirent.h>
#include <sys/stat.h>
#include <unistd.h>

#define ON_NULL(test) cmocka_unit_test_setup_teardown(test, open_null, close_fixture)

static const char head[] = "layout(local_size_x = 1) in;\n";

/* A compute program of `text`, with the module's own includes and defines. */
static strata_result create(fixture *f, const char *text, const strata_glsl *const *includes,
                            const char *const *defines, uint32_t define_count) {
    strata_program program;
    const strata_glsl source = {.text = text, .path = "folder/main.glsl"};
    const strata_program_desc desc = {.struct_size = sizeof desc,
                                      .kind = STRATA_PROGRAM_COMPUTE,
                                      .label = "program",
                                      .source = &source,
                                      .includes = includes,
                                      .defines = defines,
                                      .define_count = define_count};
    f->err = (base_error){0};
    return gpu_program_create(f->scope, &desc, &program, &f->err);
}

static void compiles(fixture *f, const char *text, const strata_glsl *const *includes) {
    if (create(f, text, includes, NULL, 0) != STRATA_OK)
        fail_msg("%s", f->err.text);
}

static void fails_at(fixture *f, const char *text, const strata_glsl *const *includes,
                     const char *place, const char *reason) {
    assert_int_equal(create(f, text, includes, NULL, 0), STRATA_ERROR_SHADER);
    assert_int_equal(gpu_last_code(f->g), GPU_ERROR_PROGRAM_COMPILE);
    if (strncmp(f->err.text, place, strlen(place)) != 0 || !strstr(f->err.text, reason))
        fail_msg("expected '%s' and '%s': %s", place, reason, f->err.text);
}

/* ---- errors name the author's place -----------------------------------------------------------
 */

static void test_error_lines(void **state) {
    fixture *f = *state;
    const strata_glsl part = {"\n\nfloat broken() { return missing; }\n", "folder/part.glsl"};
    const strata_glsl outer = {"// one\n#include \"part.glsl\"\nint also = missing_too;\n",
                               "folder/outer.glsl"};
    const strata_glsl fine = {"\nfloat fine() { return 1.0; }\n", "folder/fine.glsl"};
    const strata_glsl *const own[] = {&part, &outer, &fine, NULL};
    fails_at(f, "void main() {\n\n    nonsense;\n}\n", NULL, "folder/main.glsl:3: ", "nonsense");
    fails_at(f, "#include \"part.glsl\"\nvoid main() {}\n", own, "folder/part.glsl:3: ", "missing");
    fails_at(f, "#include \"outer.glsl\"\nvoid main() {}\n", own,
             "folder/part.glsl:3: ", "missing");
    /* After an include, lines count on where they were. */
    fails_at(f, "#include \"fine.glsl\"\nvoid main() {\n    wrong;\n}\n", own,
             "folder/main.glsl:3: ", "wrong");
    /* The library's own lines too. */
    fails_at(f, "#define vec4 broken\n#include \"strata/frame.glsl\"\nvoid main() {}\n", NULL,
             "strata/frame.glsl:", "syntax");
}

static void test_include_errors(void **state) {
    fixture *f = *state;
    const strata_glsl self = {"#include \"self.glsl\"\n", "self.glsl"};
    const strata_glsl ping = {"\n#include \"pong.glsl\"\n", "ping.glsl"};
    const strata_glsl pong = {"\n\n#include \"ping.glsl\"\n", "pong.glsl"};
    const strata_glsl *const own[] = {&self, &ping, &pong, NULL};
    fails_at(f, "\n#include \"nowhere.glsl\"\n", own, "folder/main.glsl:2: ", "nowhere.glsl");
    fails_at(f, "#include \"self.glsl\"\n", own, "self.glsl:1: ", "itself");
    fails_at(f, "#include \"ping.glsl\"\n", own, "pong.glsl:3: ", "itself");
    fails_at(f, "#include\n", own, "folder/main.glsl:1: ", "malformed");
    fails_at(f, "#include \"open\n", own, "folder/main.glsl:1: ", "malformed");
    fails_at(f, "#include \"\"\n", own, "folder/main.glsl:1: ", "malformed");
}

static void test_include_depth(void **state) {
    fixture *f = *state;
    static char texts[40][64], paths[40][16];
    static strata_glsl files[40];
    static const strata_glsl *own[41];
    for (int i = 0; i < 40; i++) {
        snprintf(texts[i], sizeof texts[i], "#include \"f%d.glsl\"\n", i + 1);
        snprintf(paths[i], sizeof paths[i], "f%d.glsl", i);
        files[i] = (strata_glsl){.text = texts[i], .path = paths[i]};
        own[i] = &files[i];
    }
    fails_at(f, "#include \"f0.glsl\"\n", own, "f", "deep");
    files[20].text = "// the end\n";
    char text[128];
    snprintf(text, sizeof text, "%s#include \"f0.glsl\"\nvoid main() {}\n", head);
    compiles(f, text, own);
}

/* Each file pastes the next twice: two to the 25th lines, were they all pasted. */
static void test_include_bomb(void **state) {
    fixture *f = *state;
    static char texts[26][96], paths[26][16];
    static strata_glsl files[26];
    static const strata_glsl *own[27];
    for (int i = 0; i < 26; i++) {
        snprintf(paths[i], sizeof paths[i], "b%d.glsl", i);
        snprintf(texts[i], sizeof texts[i], "#include \"b%d.glsl\"\n#include \"b%d.glsl\"\n", i + 1,
                 i + 1);
        files[i] = (strata_glsl){.text = texts[i], .path = paths[i]};
        own[i] = &files[i];
    }
    files[25].text = "// 64 bytes of nothing, over and over and over and over again...\n";
    fails_at(f, "#include \"b0.glsl\"\n", own, "b", "too long");
}

/* ---- finding --------------------------------------------------------------------------------- */

static void test_include_order(void **state) {
    fixture *f = *state;
    const strata_glsl mine = {"#define VALUE mine\n", "deep/folder/value.glsl"};
    const strata_glsl frame = {"#error the library comes first\n", "x/strata/frame.glsl"};
    const strata_glsl almost = {"#error another file\n", "folder/other_value.glsl"};
    const strata_glsl *const own[] = {&almost, &mine, &frame, NULL};
    const char text[] = "#include \"value.glsl\"\n"
                        "#include \"strata/frame.glsl\"\n"
                        "layout(local_size_x = 1) in;\n"
                        "layout(std430) buffer Out { uint runtime; uint mine; };\n"
                        "void main() { VALUE = 1u; }\n";
    compiles(f, text, own);
    /* A runtime include comes before the module's own, and goes again. */
    assert_int_equal(gpu_set_include(f->g, "value.glsl", "#define VALUE absent\n", &f->err),
                     STRATA_OK);
    fails_at(f, text, own, "folder/main.glsl:5: ", "absent");
    assert_int_equal(gpu_set_include(f->g, "value.glsl", "#define VALUE runtime\n", &f->err),
                     STRATA_OK);
    compiles(f, text, own);
    assert_int_equal(gpu_set_include(f->g, "value.glsl", NULL, &f->err), STRATA_OK);
    compiles(f, text, own);
    fails_at(f, text, NULL, "folder/main.glsl:1: ", "value.glsl");
}

static void test_include_forms(void **state) {
    fixture *f = *state;
    const strata_glsl one = {"#ifndef ONE\n#define ONE\nuint one() { return 1u; }\n#endif",
                             "one.glsl"};
    const strata_glsl *const own[] = {&one, NULL};
    compiles(f,
             "  #  include  \"one.glsl\"  // twice, with a guard, without a last newline\n"
             "#include <one.glsl>\r\n"
             "/* #include \"absent.glsl\"\n"
             "#include \"absent.glsl\"\n"
             "*/ // #include \"absent.glsl\" /*\n"
             "//* #include \"absent.glsl\"\n"
             "layout(local_size_x = 1) in;\n"
             "layout(std430) buffer Out { uint value; };\n"
             "void main() { value = one(); }",
             own);
}

static void test_defines(void **state) {
    fixture *f = *state;
    static const char *const defines[] = {"FLAG", "COUNT=3u", "EMPTY="};
    static const char text[] = "layout(local_size_x = 1) in;\n"
                               "layout(std430) buffer Out { uint value; };\n"
                               "#if !FLAG\n#error FLAG\n#endif\n"
                               "#ifndef STRATA_STAGE_COMPUTE\n#error stage\n#endif\n"
                               "void main() { value = COUNT EMPTY; }\n";
    assert_int_equal(create(f, text, NULL, defines, 3), STRATA_OK);
    fails_at(f, text, NULL, "folder/main.glsl:", "FLAG");
    static const char *const bad[] = {"A B=1", "=1", "", "A=1\n#error"};
    for (size_t i = 0; i < BASE_COUNT(bad); i++) {
        assert_int_equal(create(f, text, NULL, &bad[i], 1), STRATA_ERROR_INVALID_ARGUMENT);
        assert_int_equal(gpu_last_code(f->g), GPU_ERROR_VALUE);
    }
    /* Those of every program. */
    assert_int_equal(gpu_set_define(f->g, "FLAG", "1", &f->err), STRATA_OK);
    assert_int_equal(create(f, text, NULL, defines + 1, 2), STRATA_OK);
    assert_int_equal(gpu_set_define(f->g, "FLAG", "0", &f->err), STRATA_OK);
    assert_int_equal(create(f, text, NULL, defines + 1, 2), STRATA_ERROR_SHADER);
    f->err = (base_error){0};
    assert_int_equal(gpu_set_define(f->g, "FLAG", NULL, &f->err), STRATA_OK);
    assert_int_equal(create(f, text, NULL, defines, 3), STRATA_OK);
}

/* ---- reflection ------------------------------------------------------------------------------ */

static void test_unused_are_gone(void **state) {
    fixture *f = *state;
    compiles(f,
             "layout(local_size_x = 1) in;\n"
             "layout(std430) readonly buffer First { uint first[]; };\n"
             "layout(std430) buffer Unused { uint unused[]; };\n"
             "layout(std140) uniform Absent { vec4 absent; };\n"
             "uniform sampler2D nothing;\n"
             "layout(std430) buffer Last { uint last[]; };\n"
             "uint dead() { return unused[0]; }\n"
             "void main() { last[0] = first[0]; }\n",
             NULL);
    assert_logged(f, " First@");
    assert_logged(f, " Last@");
    static const char *const gone[] = {"Unused", "Absent", "nothing"};
    for (size_t i = 0; i < BASE_COUNT(gone); i++)
        assert_not_logged(f, gone[i]);
}

/* The real vertex stage and a fragment stage that uses some of the same blocks. */
static void test_stages_share(void **state) {
    fixture *f = *state;
    const strata_glsl source = {
        "#include \"strata/frame.glsl\"\n"
        "#include \"strata/scene.glsl\"\n"
        "layout(location = 0) flat in uvec4 ids;\n"
        "layout(location = 0) out vec4 color;\n"
        "STRATA_PARAMS { vec4 scale; } params;\n"
        "void main() {\n"
        "    color = strata_material_at(ids.x).base_color * params.scale *\n"
        "            strata_background;\n"
        "}\n",
        "share.glsl"};
    const strata_program_desc desc = {.struct_size = sizeof desc,
                                      .kind = STRATA_PROGRAM_SCENE,
                                      .label = "share",
                                      .source = &source};
    strata_program program;
    if (gpu_program_create(f->scope, &desc, &program, &f->err) != STRATA_OK)
        fail_msg("%s", f->err.text);
    assert_logged(f, "program share params 16 ");
    static const char *const names[] = {" StrataFrame@", " StrataMaterials@", " StrataRecords@",
                                        " StrataPositions@"};
    const char *line = strstr(gpu_null_log(f->g), "program share");
    for (size_t i = 0; i < BASE_COUNT(names); i++) { /* each once, whatever stages use it */
        const char *found = strstr(line, names[i]);
        assert_non_null(found);
        assert_null(strstr(found + 1, names[i]));
    }
}

static void test_refused_resources(void **state) {
    fixture *f = *state;
    static const struct {
        const char *declaration, *use, *reason;
    } cases[] = {
        {"uniform sampler3D volume;", "texelFetch(volume, ivec3(0), 0).x", "volume"},
        {"uniform sampler2D many[3];", "texelFetch(many[1], ivec2(0), 0).x", "many"},
        {"uniform isampler2D whole;", "float(texelFetch(whole, ivec2(0), 0).x)", "whole"},
        {"STRATA_PARAMS { vec4 large[9]; } params;", "params.large[8].x", "144 bytes"},
        {"layout(std430) readonly buffer Array { float v[]; } array[2];", "array[1].v[0]", "Array"},
    };
    for (size_t i = 0; i < BASE_COUNT(cases); i++) {
        char text[512];
        snprintf(text, sizeof text,
                 "layout(local_size_x = 1) in;\n%s\n"
                 "layout(std430) buffer Out { float value; };\n"
                 "void main() { value = %s; }\n",
                 cases[i].declaration, cases[i].use);
        fails_at(f, text, NULL, "program: ", cases[i].reason);
    }
}

static void test_lazy(void **state) {
    fixture *f = *state;
    const strata_glsl source = {"layout(local_size_x = 1) in;\n"
                                "#include \"when.glsl\"\n"
                                "layout(std430) buffer Out { uint value; };\n"
                                "void main() { value = WHEN; }\n",
                                "lazy.glsl"};
    const strata_program_desc desc = {.struct_size = sizeof desc,
                                      .kind = STRATA_PROGRAM_COMPUTE,
                                      .flags = STRATA_PROGRAM_LAZY,
                                      .label = "lazy",
                                      .source = &source};
    strata_program program;
    assert_int_equal(gpu_set_include(f->g, "when.glsl", "#define WHEN 1u\n", &f->err), STRATA_OK);
    assert_int_equal(gpu_program_create(f->scope, &desc, &program, &f->err), STRATA_OK);
    assert_not_logged(f, "program lazy");
    /* What it includes is what was there when it was made. */
    assert_int_equal(gpu_set_include(f->g, "when.glsl", NULL, &f->err), STRATA_OK);
    const strata_bind bind = bind_buffer("Out", make_buffer(f, "out", 4));
    const strata_pass pass = {.struct_size = sizeof pass,
                              .label = "first use",
                              .groups = {1},
                              .program = program,
                              .binds = &bind,
                              .bind_count = 1};
    gpu_begin(f->g, 4, 4);
    gpu_pass(f->g, "test", &pass);
    gpu_pass(f->g, "test", &pass);
    assert_int_equal(gpu_submit(f->g, &f->err), STRATA_OK);
    assert_logged(f, "program lazy params 0 Out@0\n");
    assert_null(
        strstr(strstr(gpu_null_log(f->g), "program lazy params") + 1, "program lazy params"));
}

/* ---- the cache on disk ----------------------------------------------------------------------- */

static char folder[64], entry[512];

/* Opens a device on the cache, makes the program, tells what the log says of it. */
static void use_cache(char *log, size_t size) {
    fixture f;
    open_device(&f, &(gpu_open_info){.backend = "null", .cache_dir = folder});
    compiles(&f,
             "layout(local_size_x = 1) in;\n"
             "layout(std430) buffer Out { uint value; };\n"
             "STRATA_PARAMS { uint v; } params;\n"
             "void main() { value = params.v; }\n",
             NULL);
    snprintf(log, size, "%s", gpu_null_log(f.g));
    gpu_close(f.g);
}

/* How many entries there are; `entry` names one of them. */
static int count_entries(void) {
    char path[128];
    int found = 0;
    snprintf(path, sizeof path, "%s/spirv", folder);
    DIR *directory = opendir(path);
    assert_non_null(directory);
    for (struct dirent *item = readdir(directory); item; item = readdir(directory)) {
        if (item->d_name[0] == '.')
            continue;
        snprintf(entry, sizeof entry, "%s/%s", path, item->d_name);
        found++;
    }
    closedir(directory);
    return found;
}

/* The one entry; its inode tells whether it was written again. */
static ino_t find_entry(void) {
    struct stat info;
    assert_int_equal(count_entries(), 1);
    assert_int_equal(stat(entry, &info), 0);
    return info.st_ino;
}

static void test_cache(void **state) {
    char first[1024], again[1024];
    (void)state;
    use_cache(first, sizeof first);
    ino_t written = find_entry();
    use_cache(again, sizeof again);
    assert_string_equal(first, again);
    assert_int_equal(find_entry(), written);
}

/* Entries are told apart by every byte of the text, wherever it comes from. */
static void test_cache_tells_apart(void **state) {
    fixture f;
    static const char *const defines[] = {"A=1u", "A=2u", "B=1u"};
    static const char text[] = "layout(local_size_x = 1) in;\n"
                               "#ifdef B\n"
                               "layout(std430) buffer Other { uint value; };\n"
                               "#else\n"
                               "layout(std430) buffer Out { uint value; };\n"
                               "#endif\n"
                               "void main() { value = 1u; }\n";
    (void)state;
    for (int round = 0; round < 2; round++) {
        open_device(&f, &(gpu_open_info){.backend = "null", .cache_dir = folder});
        for (size_t i = 0; i < 3; i++)
            assert_int_equal(create(&f, text, NULL, &defines[i], 1), STRATA_OK);
        assert_logged(&f, "program program params 0 Out@0\nprogram program params 0 Out@0\n"
                          "program program params 0 Other@0\n");
        gpu_close(f.g);
        assert_int_equal(count_entries(), 3);
    }
}

/* Puts `length` bytes in the entry's place, one of them spoilt unless `spoilt` lies beyond: the
 * device compiles as before, and mends the entry. */
static void check_mended(const unsigned char *sound, size_t size, size_t spoilt, size_t length,
                         const char *expected) {
    char log[1024];
    unsigned char *data = NULL;
    size_t data_size = 0;
    base_error err = {0};
    FILE *file = fopen(entry, "wb");
    assert_non_null(file);
    for (size_t i = 0; i < length; i++)
        fputc(i == spoilt ? sound[i] ^ (1 << i % 8) : sound[i], file);
    assert_int_equal(fclose(file), 0);
    use_cache(log, sizeof log);
    assert_string_equal(log, expected);
    find_entry();
    assert_int_equal(base_file_read(entry, 1 << 24, &data, &data_size, &err), STRATA_OK);
    assert_int_equal(data_size, size);
    assert_memory_equal(data, sound, size);
    free(data);
}

static void test_cache_spoilt(void **state) {
    char expected[1024];
    unsigned char *data = NULL;
    size_t size = 0;
    base_error err = {0};
    (void)state;
    use_cache(expected, sizeof expected);
    find_entry();
    assert_int_equal(base_file_read(entry, 1 << 24, &data, &size, &err), STRATA_OK);
    for (size_t i = 0; i < 64; i++) /* the header */
        check_mended(data, size, i, size, expected);
    for (size_t i = 64; i < size; i += 97)
        check_mended(data, size, i, size, expected);
    check_mended(data, size, size - 1, size, expected);
    for (size_t i = 0; i < 20; i++) /* cut short */
        check_mended(data, size, size, i * size / 20, expected);
    free(data);
}

static void test_cache_unwritable(void **state) {
    fixture f;
    (void)state;
    open_device(&f, &(gpu_open_info){.backend = "null", .cache_dir = "/dev/null/nowhere"});
    compiles(&f, "layout(local_size_x = 1) in;\nvoid main() {}\n", NULL);
    gpu_close(f.g);
}

static int make_folder(void **state) {
    (void)state;
    snprintf(folder, sizeof folder, "/tmp/strata-shader-XXXXXX");
    return mkdtemp(folder) ? 0 : -1;
}

static int remove_folder(void **state) {
    char command[128];
    (void)state;
    snprintf(command, sizeof command, "rm -rf '%s'", folder);
    return system(command);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        ON_NULL(test_error_lines),
        ON_NULL(test_include_errors),
        ON_NULL(test_include_depth),
        ON_NULL(test_include_bomb),
        ON_NULL(test_include_order),
        ON_NULL(test_include_forms),
        ON_NULL(test_defines),
        ON_NULL(test_unused_are_gone),
        ON_NULL(test_stages_share),
        ON_NULL(test_refused_resources),
        ON_NULL(test_lazy),
        cmocka_unit_test_setup_teardown(test_cache, make_folder, remove_folder),
        cmocka_unit_test_setup_teardown(test_cache_tells_apart, make_folder, remove_folder),
        cmocka_unit_test_setup_teardown(test_cache_spoilt, make_folder, remove_folder),
        cmocka_unit_test(test_cache_unwritable),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
