/*
 * Prints which objects the cameras of a path may see, as `antumbra cull` does: a line for each frame, its number and the
 * objects.
 *
 *     visible SCENE PATH.json [best|scalar|sse4.2|avx2|avx512|neon [THREADS]]
 */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "antumbra.h"

static int complain(const char *what, AntumbraStatus status)
{
    fprintf(stderr, "error: %s: %s (%s)\n", what, antumbra_last_error(), antumbra_status_name(status));
    return 1;
}

static int level_of(const char *name, uint32_t *level)
{
    static const char *const names[] = {"best", "scalar", "sse4.2", "avx2", "avx512", "neon"};
    uint32_t i;
    for (i = 0; i < sizeof names / sizeof names[0]; i++) {
        if (strcmp(name, names[i]) == 0) {
            *level = i;
            return 1;
        }
    }
    return 0;
}

static int print_visible(const AntumbraCameraPath *path, AntumbraCuller *culler)
{
    size_t frame, i;
    for (frame = 0; frame < antumbra_camera_path_length(path); frame++) {
        AntumbraCamera camera;
        const uint32_t *objects;
        size_t count;
        AntumbraStatus status = antumbra_camera_path_frame(path, frame, &camera);
        if (status != ANTUMBRA_OK) {
            return complain("camera", status);
        }
        status = antumbra_culler_cull(culler, &camera, &objects, &count);
        if (status != ANTUMBRA_OK) {
            return complain("culling", status);
        }
        /* The list is the culler's own until its next frame: an engine would draw from it. */
        printf("%lu:", (unsigned long)frame);
        for (i = 0; i < count; i++) {
            printf(" %lu", (unsigned long)objects[i]);
        }
        printf("\n");
    }
    return 0;
}

int main(int argc, char **argv)
{
    AntumbraSettings settings;
    AntumbraScene *scene = NULL;
    AntumbraCameraPath *path = NULL;
    AntumbraCuller *culler = NULL;
    AntumbraStatus status;
    int code = 1;

    if ((status = antumbra_settings_init(&settings, sizeof settings)) != ANTUMBRA_OK) {
        return complain("settings", status);
    }
    settings.width = 1280;
    settings.height = 768;
    if (argc < 3 || argc > 5 || (argc > 3 && !level_of(argv[3], &settings.level))) {
        fprintf(stderr, "usage: visible SCENE PATH.json [best|scalar|sse4.2|avx2|avx512|neon [THREADS]]\n");
        return 2;
    }
    if (argc > 4) {
        settings.threads = (uint32_t)strtoul(argv[4], NULL, 10);
    }

    if ((status = antumbra_scene_load(argv[1], settings.threads, &scene)) != ANTUMBRA_OK) {
        complain("scene", status);
    } else if ((status = antumbra_camera_path_load(argv[2], &path)) != ANTUMBRA_OK) {
        complain("path", status);
    } else if ((status = antumbra_culler_create(scene, &settings, &culler)) != ANTUMBRA_OK) {
        complain("culler", status);
    } else {
        code = print_visible(path, culler);
    }
    antumbra_culler_destroy(culler);
    antumbra_camera_path_destroy(path);
    antumbra_scene_destroy(scene);
    return code;
}
