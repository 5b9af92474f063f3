/*
 * Claims about the interface, from where it is used. Run under valgrind, it also shows that nothing is read or written that is not
 * there, and that what is destroyed is gone.
 *
 *     interface FOLDER LEVEL          a folder to write into; a number of AntumbraLevel, 0 for the best
 */
#include <math.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "antumbra.h"

static int failures = 0;

static void is_true(int holds, int line, const char *claim)
{
    if (!holds) {
        failures++;
        fprintf(stderr, "line %d: not so: %s; last error: %s\n", line, claim, antumbra_last_error());
    }
}

static void is_status(AntumbraStatus found, AntumbraStatus expected, int line, const char *call)
{
    if (found != expected) {
        failures++;
        fprintf(stderr, "line %d: %s gives %s, not %s; last error: %s\n", line, call, antumbra_status_name(found),
                antumbra_status_name(expected), antumbra_last_error());
    }
}

#define CLAIM(holds) is_true((holds) ? 1 : 0, __LINE__, #holds)
#define OK(call) is_status((call), ANTUMBRA_OK, __LINE__, #call)
#define FAILS(status, call) is_status((call), ANTUMBRA_ERROR_##status, __LINE__, #call)

static const double ORIGIN[3] = {0, 0, 0};
static const double UP[3] = {0, 1, 0};
static uint32_t level;

static AntumbraProjection perspective(void)
{
    AntumbraProjection projection = {ANTUMBRA_PERSPECTIVE, 1.0, 0.1, INFINITY};
    return projection;
}

/* A camera ten units before the origin, moved sideways. */
static AntumbraCamera camera_at(double x)
{
    double eye[3] = {0, 1, 10}, target[3] = {0, 1, 0};
    AntumbraProjection projection = perspective();
    AntumbraCamera camera;
    eye[0] = target[0] = x;
    OK(antumbra_camera_look_at(eye, target, UP, &projection, &camera));
    return camera;
}

static AntumbraSettings settings_for(uint32_t width, uint32_t height)
{
    AntumbraSettings settings;
    OK(antumbra_settings_init(&settings, sizeof settings));
    settings.width = width;
    settings.height = height;
    settings.threads = 2;
    settings.level = level;
    return settings;
}

/* A unit cube around the origin, counter-clockwise from outside. */
static const float CUBE[8][3] = {{-.5f, -.5f, -.5f}, {.5f, -.5f, -.5f}, {-.5f, .5f, -.5f}, {.5f, .5f, -.5f},
                                 {-.5f, -.5f, .5f},  {.5f, -.5f, .5f},  {-.5f, .5f, .5f},  {.5f, .5f, .5f}};
static const uint32_t CUBE_INDICES[36] = {0, 2, 3, 0, 3, 1, 4, 5, 7, 4, 7, 6, 0, 1, 5, 0, 5, 4,
                                          2, 6, 7, 2, 7, 3, 0, 4, 6, 0, 6, 2, 1, 3, 7, 1, 7, 5};

/* Column by column: a cube of this size at this place. */
static void place(double *matrix, double x, double y, double z, double width, double height, double depth)
{
    memset(matrix, 0, 16 * sizeof *matrix);
    matrix[0] = width;
    matrix[5] = height;
    matrix[10] = depth;
    matrix[12] = x;
    matrix[13] = y;
    matrix[14] = z;
    matrix[15] = 1;
}

enum { WALL, BEHIND, BESIDE, LAMP, OBJECTS };

/* A wall, a box behind it, a box beside it, and a lamp behind it that is never culled. */
static AntumbraScene *yard(void)
{
    AntumbraSceneBuilder *builder;
    AntumbraScene *scene;
    uint32_t mesh, object;
    double matrix[16];
    OK(antumbra_scene_builder_create(&builder));
    OK(antumbra_scene_builder_add_mesh(builder, CUBE[0], 8, sizeof CUBE[0], &mesh));
    OK(antumbra_scene_builder_add_surface(builder, mesh, CUBE_INDICES, 36, NULL));
    place(matrix, 0, 2, 0, 6, 4, 0.2);
    OK(antumbra_scene_builder_add_object(builder, mesh, matrix, 0, &object));
    CLAIM(object == WALL);
    OK(antumbra_scene_builder_set_object_name(builder, object, "w\xc3\xa4nd"));
    place(matrix, 0, 1, -3, 1, 1, 1);
    OK(antumbra_scene_builder_add_object(builder, mesh, matrix, 0, NULL));
    place(matrix, 5, 1, 0, 1, 1, 1);
    OK(antumbra_scene_builder_add_object(builder, mesh, matrix, ANTUMBRA_OBJECT_NEVER_OCCLUDE, &object));
    CLAIM(object == BESIDE);
    place(matrix, 1, 1, -3, 0.5, 0.5, 0.5);
    OK(antumbra_scene_builder_add_object(builder, mesh, matrix, ANTUMBRA_OBJECT_NEVER_CULL, &object));
    OK(antumbra_scene_builder_build(builder, 1, &scene));
    antumbra_scene_builder_destroy(builder);
    return scene;
}

static void cameras(void)
{
    const double target[3] = {0, 0, -1}, nan_point[3] = {NAN, 0, 0};
    AntumbraProjection projection = perspective(), wrong = projection;
    AntumbraCamera camera, same;
    /* The camera at (3, 1, 10), looking along -z. */
    double view[16] = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, -3, -1, -10, 1};

    OK(antumbra_camera_look_at(ORIGIN, target, UP, &projection, &camera));
    CLAIM(camera.forward[2] == -1 && camera.right[0] == 1 && camera.up[1] == 1);
    FAILS(NULL_POINTER, antumbra_camera_look_at(NULL, target, UP, &projection, &camera));
    FAILS(NULL_POINTER, antumbra_camera_look_at(ORIGIN, target, UP, NULL, &camera));
    FAILS(NULL_POINTER, antumbra_camera_look_at(ORIGIN, target, UP, &projection, NULL));
    FAILS(INVALID_ARGUMENT, antumbra_camera_look_at(ORIGIN, ORIGIN, UP, &projection, &camera));
    FAILS(INVALID_ARGUMENT, antumbra_camera_look_at(nan_point, target, UP, &projection, &camera));
    wrong.near_plane = 0;
    FAILS(INVALID_ARGUMENT, antumbra_camera_look_at(ORIGIN, target, UP, &wrong, &camera));
    wrong = projection;
    wrong.far_plane = NAN;
    FAILS(INVALID_ARGUMENT, antumbra_camera_look_at(ORIGIN, target, UP, &wrong, &camera));
    wrong = projection;
    wrong.kind = 2;
    FAILS(INVALID_ARGUMENT, antumbra_camera_look_at(ORIGIN, target, UP, &wrong, &camera));
    wrong.kind = ANTUMBRA_ORTHOGRAPHIC;
    wrong.near_plane = -5;
    wrong.far_plane = 5;
    OK(antumbra_camera_look_at(ORIGIN, target, UP, &wrong, &camera));

    camera = camera_at(3);
    OK(antumbra_camera_from_view(view, &projection, &same));
    CLAIM(memcmp(camera.eye, same.eye, sizeof camera.eye) == 0 && camera.forward[2] == same.forward[2]);
    view[0] = 2;
    FAILS(INVALID_ARGUMENT, antumbra_camera_from_view(view, &projection, &same));
    view[0] = -1;
    FAILS(INVALID_ARGUMENT, antumbra_camera_from_view(view, &projection, &same));
    view[0] = 1;
    view[3] = -3;
    FAILS(INVALID_ARGUMENT, antumbra_camera_from_view(view, &projection, &same));
    CLAIM(strstr(antumbra_last_error(), "column by column") != NULL);
}

static void builders(void)
{
    const uint32_t out_of_range[3] = {0, 1, 8};
    const float nan_positions[9] = {0, 0, 0, NAN, 0, 0, 0, 1, 0};
    const AntumbraMaterial glass = {ANTUMBRA_ALPHA_BLEND, 1, 0.5f}, wrong = {3, 0, 1};
    AntumbraSceneBuilder *builder;
    AntumbraScene *scene = (AntumbraScene *)&builder;
    uint32_t mesh, object;
    double matrix[16];

    OK(antumbra_scene_builder_create(&builder));
    FAILS(SCENE, antumbra_scene_builder_build(builder, 1, &scene));
    CLAIM(scene == NULL);
    FAILS(NULL_POINTER, antumbra_scene_builder_add_mesh(builder, NULL, 8, 12, &mesh));
    FAILS(INVALID_ARGUMENT, antumbra_scene_builder_add_mesh(builder, CUBE[0], 8, 8, &mesh));
    FAILS(INVALID_ARGUMENT, antumbra_scene_builder_add_mesh(builder, CUBE[0], 8, 13, &mesh));
    FAILS(INVALID_ARGUMENT, antumbra_scene_builder_add_mesh(builder, CUBE[0], SIZE_MAX, 12, &mesh));
    FAILS(INVALID_ARGUMENT,
          antumbra_scene_builder_add_mesh(builder, (const float *)((const char *)CUBE + 1), 7, 12, &mesh));
    OK(antumbra_scene_builder_add_mesh(builder, CUBE[0], 8, sizeof CUBE[0], &mesh));
    FAILS(OUT_OF_RANGE, antumbra_scene_builder_add_surface(builder, 1, CUBE_INDICES, 36, NULL));
    FAILS(OUT_OF_RANGE, antumbra_scene_builder_add_surface(builder, mesh, out_of_range, 3, NULL));
    FAILS(INVALID_ARGUMENT, antumbra_scene_builder_add_surface(builder, mesh, CUBE_INDICES, 35, NULL));
    FAILS(INVALID_ARGUMENT, antumbra_scene_builder_add_surface(builder, mesh, CUBE_INDICES, 36, &wrong));
    OK(antumbra_scene_builder_add_surface(builder, mesh, CUBE_INDICES, 18, &glass));
    OK(antumbra_scene_builder_add_surface(builder, mesh, CUBE_INDICES + 18, 18, NULL));
    FAILS(OUT_OF_RANGE, antumbra_scene_builder_add_object(builder, 1, NULL, 0, &object));
    FAILS(INVALID_ARGUMENT, antumbra_scene_builder_add_object(builder, mesh, NULL, 4, &object));
    place(matrix, 0, 0, 0, 1, NAN, 1);
    FAILS(INVALID_ARGUMENT, antumbra_scene_builder_add_object(builder, mesh, matrix, 0, &object));
    OK(antumbra_scene_builder_add_object(builder, mesh, NULL, 0, &object));
    FAILS(OUT_OF_RANGE, antumbra_scene_builder_set_object_name(builder, 1, "none"));
    FAILS(UTF8, antumbra_scene_builder_set_object_name(builder, object, "\xff"));
    FAILS(OUT_OF_RANGE, antumbra_scene_builder_set_occluder_proxy(builder, object, 1));
    OK(antumbra_scene_builder_set_occluder_proxy(builder, object, mesh));
    OK(antumbra_scene_builder_build(builder, 0, &scene));
    CLAIM(antumbra_scene_object_count(scene) == 1 && antumbra_scene_triangle_count(scene) == 12);
    antumbra_scene_destroy(scene);

    /* The builder is empty again. */
    OK(antumbra_scene_builder_add_mesh(builder, nan_positions, 3, 12, &mesh));
    CLAIM(mesh == 0);
    OK(antumbra_scene_builder_add_surface(builder, mesh, CUBE_INDICES + 8, 0, NULL));
    OK(antumbra_scene_builder_add_object(builder, mesh, NULL, 0, NULL));
    FAILS(SCENE, antumbra_scene_builder_build(builder, 1, &scene));
    CLAIM(strstr(antumbra_last_error(), "not finite") != NULL);
    antumbra_scene_builder_destroy(builder);
    antumbra_scene_builder_destroy(NULL);
    FAILS(NULL_POINTER, antumbra_scene_builder_add_mesh(NULL, CUBE[0], 8, 12, &mesh));
    FAILS(NULL_POINTER, antumbra_scene_builder_create(NULL));
}

static void scenes(const char *folder)
{
    AntumbraScene *scene = yard(), *again;
    AntumbraCameraPath *path;
    AntumbraBox bounds;
    const char *name;
    char file[4096];

    OK(antumbra_scene_object_name(scene, WALL, &name));
    CLAIM(strcmp(name, "w\xc3\xa4nd") == 0);
    FAILS(OUT_OF_RANGE, antumbra_scene_object_name(scene, OBJECTS, &name));
    CLAIM(name != NULL);
    OK(antumbra_scene_object_bounds(scene, BESIDE, &bounds));
    CLAIM(fabs(bounds.min[0] - 4.5) < 1e-9 && fabs(bounds.max[0] - 5.5) < 1e-9);
    FAILS(OUT_OF_RANGE, antumbra_scene_object_bounds(scene, OBJECTS, &bounds));
    CLAIM(antumbra_scene_warning_count(scene) == 0);
    FAILS(OUT_OF_RANGE, antumbra_scene_warning(scene, 0, &name));

    sprintf(file, "%.4000s/yard.antumbra", folder);
    OK(antumbra_scene_save(scene, file));
    OK(antumbra_scene_load(file, 2, &again));
    CLAIM(antumbra_scene_object_count(again) == OBJECTS);
    antumbra_scene_destroy(again);
    sprintf(file, "%.4000s/none/yard.antumbra", folder);
    FAILS(IO, antumbra_scene_save(scene, file));
    FAILS(IO, antumbra_scene_load(file, 1, &again));
    CLAIM(again == NULL && strstr(antumbra_last_error(), "yard.antumbra") != NULL);
    FAILS(FILE, antumbra_scene_load("yard.txt", 1, &again));
    FAILS(UTF8, antumbra_scene_load("\xff.glb", 1, &again));
    FAILS(NULL_POINTER, antumbra_scene_load(NULL, 1, &again));
    FAILS(NULL_POINTER, antumbra_scene_load(file, 1, NULL));
    FAILS(NULL_POINTER, antumbra_scene_save(NULL, file));
    FAILS(IO, antumbra_camera_path_load(file, &path));
    CLAIM(path == NULL && antumbra_camera_path_length(path) == 0);
    antumbra_scene_destroy(scene);
    antumbra_scene_destroy(NULL);
    CLAIM(antumbra_scene_object_count(NULL) == 0 && antumbra_scene_triangle_count(NULL) == 0);
}

static void frames(void)
{
    AntumbraScene *scene = yard();
    AntumbraSettings settings = settings_for(320, 192), wrong;
    AntumbraCamera camera = camera_at(0), none;
    AntumbraCuller *culler, *another;
    AntumbraMemory *memory;
    AntumbraStatistics statistics;
    AntumbraMove to;
    AntumbraCluster cluster;
    const AntumbraCluster *clusters;
    const AntumbraDrawnCluster *drawn;
    const AntumbraBox boxes[3] = {
        {{-1, 0, -4}, {1, 1, -3}}, {{-1, 0, 1}, {1, 1, 2}}, {{NAN, 0, 0}, {1, 1, 1}}};
    AntumbraVisibility answers[3];
    float corners[ANTUMBRA_TRIANGLES_PER_CLUSTER * 9];
    const float *levels;
    const uint32_t *objects, *whole;
    size_t count, whole_count;
    uint64_t hash, hash_again;

    wrong = settings;
    wrong.width = 0;
    FAILS(INVALID_ARGUMENT, antumbra_culler_create(scene, &wrong, &culler));
    CLAIM(culler == NULL);
    wrong = settings;
    wrong.struct_size = 8;
    FAILS(STRUCT_SIZE, antumbra_culler_create(scene, &wrong, &culler));
    FAILS(STRUCT_SIZE, antumbra_settings_init(&wrong, 8));
    wrong = settings;
    wrong.level = antumbra_best_level() == ANTUMBRA_LEVEL_NEON ? ANTUMBRA_LEVEL_AVX2 : ANTUMBRA_LEVEL_NEON;
    FAILS(LEVEL, antumbra_culler_create(scene, &wrong, &culler));
    FAILS(NULL_POINTER, antumbra_culler_create(NULL, &settings, &culler));
    FAILS(NULL_POINTER, antumbra_culler_create(scene, NULL, &culler));
    FAILS(NULL_POINTER, antumbra_culler_create(scene, &settings, NULL));

    OK(antumbra_culler_create(scene, &settings, &culler));
    /* The culler keeps what it needs. */
    antumbra_scene_destroy(scene);

    FAILS(STATE, antumbra_culler_visibility_levels(culler, &levels, &count));
    FAILS(STATE, antumbra_culler_appearances(culler, &objects, &count));
    FAILS(STATE, antumbra_culler_visible_clusters(culler, &clusters, &count, &whole, &whole_count));
    FAILS(STATE, antumbra_culler_drawn_clusters(culler, &drawn, &count));
    FAILS(STATE, antumbra_culler_statistics(culler, &statistics, sizeof statistics));
    FAILS(STATE, antumbra_culler_test_boxes(culler, boxes, 3, answers));
    FAILS(STATE, antumbra_culler_buffer_hash(culler, &hash));

    OK(antumbra_culler_cull(culler, &camera, &objects, &count));
    CLAIM(count == 3 && objects[0] == WALL && objects[1] == BESIDE && objects[2] == LAMP);
    FAILS(NULL_POINTER, antumbra_culler_cull(NULL, &camera, &objects, &count));
    CLAIM(objects == NULL && count == 0);
    FAILS(NULL_POINTER, antumbra_culler_cull(culler, NULL, &objects, &count));
    FAILS(NULL_POINTER, antumbra_culler_cull(culler, &camera, NULL, &count));
    FAILS(NULL_POINTER, antumbra_culler_cull(culler, &camera, &objects, NULL));
    memset(&none, 0, sizeof none);
    FAILS(INVALID_ARGUMENT, antumbra_culler_cull(culler, &none, &objects, &count));
    none = camera;
    none.eye[1] = NAN;
    FAILS(INVALID_ARGUMENT, antumbra_culler_cull(culler, &none, &objects, &count));

    OK(antumbra_culler_in_frustum(culler, &camera, &objects, &count));
    CLAIM(count == OBJECTS);
    OK(antumbra_culler_visibility_levels(culler, &levels, &count));
    CLAIM(count == 3 && levels[0] > 0 && levels[0] <= 1);
    OK(antumbra_culler_statistics(culler, &statistics, sizeof statistics));
    CLAIM(statistics.objects_visible == 3 && statistics.occluder_triangles > 0);
    OK(antumbra_culler_test_boxes(culler, boxes, 3, answers));
    CLAIM(answers[0].answer == ANTUMBRA_OCCLUDED && answers[0].level == 0);
    CLAIM(answers[1].answer == ANTUMBRA_VISIBLE && answers[1].level > 0);
    CLAIM(answers[2].answer == ANTUMBRA_VISIBLE);
    OK(antumbra_culler_test_boxes(culler, NULL, 0, NULL));
    FAILS(NULL_POINTER, antumbra_culler_test_boxes(culler, NULL, 3, answers));
    FAILS(NULL_POINTER, antumbra_culler_test_boxes(culler, boxes, 3, NULL));

    OK(antumbra_culler_visible_clusters(culler, &clusters, &count, &whole, &whole_count));
    CLAIM(count == 2 && clusters[0].object == WALL && clusters[1].object == LAMP);
    CLAIM(whole_count == 1 && whole[0] == BESIDE);
    OK(antumbra_culler_drawn_clusters(culler, &drawn, &count));
    CLAIM(count > 0 && drawn[0].cluster.object == WALL && drawn[0].gain > 0);
    cluster = drawn[0].cluster;
    OK(antumbra_culler_cluster_triangles(culler, cluster, corners, ANTUMBRA_TRIANGLES_PER_CLUSTER, &count));
    CLAIM(count == 12 && fabsf(corners[0]) == 0.5f && fabsf(corners[12 * 9 - 1]) == 0.5f);
    OK(antumbra_culler_cluster_triangles(culler, cluster, NULL, 0, &count));
    CLAIM(count == 12);
    cluster.cluster = 1;
    FAILS(OUT_OF_RANGE, antumbra_culler_cluster_triangles(culler, cluster, NULL, 0, &count));
    cluster.object = OBJECTS;
    FAILS(OUT_OF_RANGE, antumbra_culler_cluster_triangles(culler, cluster, NULL, 0, &count));

    OK(antumbra_culler_set_salience(culler, LAMP, 1));
    FAILS(OUT_OF_RANGE, antumbra_culler_set_salience(culler, OBJECTS, 1));
    FAILS(INVALID_ARGUMENT, antumbra_culler_set_salience(culler, LAMP, NAN));

    /* What is remembered makes a frame again. */
    OK(antumbra_culler_remember(culler, &memory));
    OK(antumbra_culler_appearances(culler, &objects, &count));
    CLAIM(count == 0);
    camera = camera_at(12);
    OK(antumbra_culler_cull(culler, &camera, &objects, &count));
    OK(antumbra_culler_buffer_hash(culler, &hash));
    OK(antumbra_culler_appearances(culler, &objects, &count));
    CLAIM(count == 1 && objects[0] == BEHIND);
    OK(antumbra_culler_recall(culler, memory));
    OK(antumbra_culler_cull(culler, &camera, &objects, &count));
    OK(antumbra_culler_buffer_hash(culler, &hash_again));
    CLAIM(hash == hash_again);
    CLAIM(count > 0);
    OK(antumbra_culler_cull(culler, &camera, &objects, &count));
    OK(antumbra_culler_statistics(culler, &statistics, sizeof statistics));
    CLAIM(statistics.skipped & ANTUMBRA_SKIPPED_EVERYTHING);
    OK(antumbra_culler_forget(culler));

    /* The box comes out from behind the wall, and goes back. */
    camera = camera_at(0);
    memset(&to, 0, sizeof to);
    to.object = BEHIND;
    place(to.world_from_local, -5, 1, -3, 1, 1, 1);
    OK(antumbra_culler_move_objects(culler, &to, 1));
    OK(antumbra_culler_cull(culler, &camera, &objects, &count));
    CLAIM(count == OBJECTS);
    place(to.world_from_local, 0, 1, -3, 1, 1, 1);
    OK(antumbra_culler_move_objects(culler, &to, 1));
    /* What was seen is taken for visible for some frames, unless it is forgotten. */
    OK(antumbra_culler_forget(culler));
    OK(antumbra_culler_cull(culler, &camera, &objects, &count));
    CLAIM(count == OBJECTS - 1);
    to.world_from_local[12] = NAN;
    FAILS(INVALID_ARGUMENT, antumbra_culler_move_objects(culler, &to, 1));
    to.world_from_local[12] = 1e300;
    FAILS(SCENE, antumbra_culler_move_objects(culler, &to, 1));
    to.world_from_local[12] = 0;
    to.swept = 2;
    FAILS(INVALID_ARGUMENT, antumbra_culler_move_objects(culler, &to, 1));
    to.swept = 1;
    to.object = OBJECTS;
    FAILS(OUT_OF_RANGE, antumbra_culler_move_objects(culler, &to, 1));
    FAILS(NULL_POINTER, antumbra_culler_move_objects(culler, NULL, 1));
    OK(antumbra_culler_move_objects(culler, NULL, 0));

    FAILS(INVALID_ARGUMENT, antumbra_culler_resize(culler, 0, 100));
    OK(antumbra_culler_resize(culler, 320, 192));
    OK(antumbra_culler_statistics(culler, &statistics, sizeof statistics));
    OK(antumbra_culler_resize(culler, 101, 67));
    FAILS(STATE, antumbra_culler_statistics(culler, &statistics, sizeof statistics));
    OK(antumbra_culler_cull(culler, &camera, &objects, &count));
    CLAIM(count == OBJECTS - 1);
    /* What is remembered is of the scene, wherever its objects are now. */
    OK(antumbra_culler_recall(culler, memory));

    settings.threads = 1;
    settings.accuracy = ANTUMBRA_APPROXIMATE;
    OK(antumbra_culler_another(culler, &settings, &another));
    antumbra_culler_destroy(culler);
    OK(antumbra_culler_recall(another, memory));
    camera = camera_at(0);
    OK(antumbra_culler_cull(another, &camera, &objects, &count));
    CLAIM(count == 3);

    /* A memory of another scene means nothing here. */
    scene = yard();
    OK(antumbra_culler_create(scene, &settings, &culler));
    FAILS(INVALID_ARGUMENT, antumbra_culler_recall(culler, memory));
    antumbra_memory_destroy(memory);
    antumbra_memory_destroy(NULL);
    antumbra_culler_destroy(another);
    antumbra_culler_destroy(culler);
    antumbra_culler_destroy(NULL);
    antumbra_scene_destroy(scene);
}

static void buffers(void)
{
    enum { WIDTH = 100, HEIGHT = 60 };
    const uint32_t out_of_range[3] = {0, 1, 8};
    const double center[3] = {0, 1, -3}, x[2] = {45, 55}, y[2] = {25, 35};
    const AntumbraBox boxes[2] = {{{-1, 0, -4}, {1, 1, -3}}, {{-1, 0, 1}, {1, 1, 2}}};
    const AntumbraOrientedBox oriented = {{0, 1, -3}, {{0.5, 0.5, 0}, {-0.5, 0.5, 0}, {0, 0, 0.5}}};
    AntumbraCamera camera = camera_at(0);
    AntumbraOcclusionBuffer *buffer;
    AntumbraApproximation approximation;
    AntumbraOccluder wall, wrong;
    AntumbraVisibility answers[2];
    double matrix[16];
    float *depths = malloc(WIDTH * HEIGHT * sizeof *depths);
    uint64_t empty, hash, pixels;

    FAILS(INVALID_ARGUMENT, antumbra_occlusion_buffer_create(0, HEIGHT, 1, &camera, &buffer));
    CLAIM(buffer == NULL);
    FAILS(INVALID_ARGUMENT, antumbra_occlusion_buffer_create(WIDTH, HEIGHT, 3, &camera, &buffer));
    FAILS(NULL_POINTER, antumbra_occlusion_buffer_create(WIDTH, HEIGHT, 1, NULL, &buffer));
    FAILS(NULL_POINTER, antumbra_occlusion_buffer_create(WIDTH, HEIGHT, 1, &camera, NULL));
    OK(antumbra_occlusion_buffer_create(WIDTH, HEIGHT, 1, &camera, &buffer));
    OK(antumbra_occlusion_buffer_set_level(buffer, level));
    FAILS(INVALID_ARGUMENT, antumbra_occlusion_buffer_set_level(buffer, 99));
    OK(antumbra_occlusion_buffer_hash(buffer, &empty));

    memset(&wall, 0, sizeof wall);
    place(matrix, 0, 2, 0, 6, 4, 0.2);
    wall.positions = CUBE[0];
    wall.vertex_count = 8;
    wall.stride = sizeof CUBE[0];
    wall.indices = CUBE_INDICES;
    wall.index_count = 36;
    wall.world_from_local = matrix;
    wrong = wall;
    wrong.indices = out_of_range;
    wrong.index_count = 3;
    FAILS(OUT_OF_RANGE, antumbra_occlusion_buffer_draw(buffer, &wrong));
    wrong = wall;
    wrong.index_count = 35;
    FAILS(INVALID_ARGUMENT, antumbra_occlusion_buffer_draw(buffer, &wrong));
    wrong = wall;
    wrong.positions = NULL;
    FAILS(NULL_POINTER, antumbra_occlusion_buffer_draw(buffer, &wrong));
    wrong = wall;
    wrong.cull_mode = 3;
    FAILS(INVALID_ARGUMENT, antumbra_occlusion_buffer_draw(buffer, &wrong));
    FAILS(NULL_POINTER, antumbra_occlusion_buffer_draw(buffer, NULL));
    FAILS(NULL_POINTER, antumbra_occlusion_buffer_draw(NULL, &wall));
    OK(antumbra_occlusion_buffer_hash(buffer, &hash));
    CLAIM(hash == empty);

    OK(antumbra_occlusion_buffer_draw(buffer, &wall));
    FAILS(STATE, antumbra_occlusion_buffer_set_approximation(buffer, NULL));
    OK(antumbra_occlusion_buffer_test_boxes(buffer, boxes, 2, answers));
    OK(antumbra_occlusion_buffer_finish(buffer));
    OK(antumbra_occlusion_buffer_finish(buffer));
    FAILS(STATE, antumbra_occlusion_buffer_draw(buffer, &wall));
    FAILS(STATE, antumbra_occlusion_buffer_draw_translucent(buffer, &wall, 0.5f));
    OK(antumbra_occlusion_buffer_test_boxes(buffer, boxes, 2, answers));
    CLAIM(answers[0].answer == ANTUMBRA_OCCLUDED && answers[1].answer == ANTUMBRA_VISIBLE);
    OK(antumbra_occlusion_buffer_test_oriented_boxes(buffer, &oriented, 1, answers));
    CLAIM(answers[0].answer == ANTUMBRA_OCCLUDED);
    OK(antumbra_occlusion_buffer_test_sphere(buffer, center, 0.5, answers));
    CLAIM(answers[0].answer == ANTUMBRA_OCCLUDED);
    OK(antumbra_occlusion_buffer_test_sphere(buffer, center, NAN, answers));
    CLAIM(answers[0].answer == ANTUMBRA_VISIBLE);
    OK(antumbra_occlusion_buffer_test_rectangle(buffer, x, y, 12, answers));
    CLAIM(answers[0].answer == ANTUMBRA_OCCLUDED);
    OK(antumbra_occlusion_buffer_test_rectangle(buffer, x, y, 8, answers));
    CLAIM(answers[0].answer == ANTUMBRA_VISIBLE);
    FAILS(NULL_POINTER, antumbra_occlusion_buffer_test_sphere(buffer, NULL, 0.5, answers));
    FAILS(NULL_POINTER, antumbra_occlusion_buffer_test_rectangle(buffer, x, NULL, 8, answers));

    OK(antumbra_occlusion_buffer_read_depth(buffer, depths, WIDTH * HEIGHT));
    /* near / distance of the wall's front, or a little farther; nothing in the corner. */
    CLAIM(depths[HEIGHT / 2 * WIDTH + WIDTH / 2] <= 0.1f / 9.9f && depths[HEIGHT / 2 * WIDTH + WIDTH / 2] > 0.01f);
    CLAIM(depths[0] == -INFINITY);
    FAILS(INVALID_ARGUMENT, antumbra_occlusion_buffer_read_depth(buffer, depths, WIDTH));
    FAILS(NULL_POINTER, antumbra_occlusion_buffer_read_depth(buffer, NULL, WIDTH * HEIGHT));

    OK(antumbra_occlusion_buffer_clear(buffer, &camera));
    OK(antumbra_occlusion_buffer_hash(buffer, &hash));
    CLAIM(hash == empty);
    OK(antumbra_approximation_init(&approximation));
    approximation.distribution = 5;
    FAILS(INVALID_ARGUMENT, antumbra_occlusion_buffer_set_approximation(buffer, &approximation));
    OK(antumbra_approximation_init(&approximation));
    OK(antumbra_occlusion_buffer_set_approximation(buffer, &approximation));
    OK(antumbra_occlusion_buffer_draw(buffer, &wall));
    OK(antumbra_occlusion_buffer_draw_translucent(buffer, &wall, 0.5f));
    FAILS(INVALID_ARGUMENT, antumbra_occlusion_buffer_draw_translucent(buffer, &wall, 2));
    OK(antumbra_occlusion_buffer_finish(buffer));
    OK(antumbra_occlusion_buffer_ignored_pixels(buffer, &pixels));
    CLAIM(pixels < WIDTH * HEIGHT);
    antumbra_occlusion_buffer_destroy(buffer);
    antumbra_occlusion_buffer_destroy(NULL);
    free(depths);
}

int main(int argc, char **argv)
{
    char version[64];
    if (argc != 3) {
        fprintf(stderr, "usage: interface FOLDER LEVEL\n");
        return 2;
    }
    level = (uint32_t)strtoul(argv[2], NULL, 10);
    CLAIM(strcmp(antumbra_last_error(), "") == 0);
    sprintf(version, "%d.%d.%d", ANTUMBRA_VERSION_MAJOR, ANTUMBRA_VERSION_MINOR, ANTUMBRA_VERSION_PATCH);
    CLAIM(strcmp(version, antumbra_version()) == 0);
    cameras();
    builders();
    scenes(argv[1]);
    frames();
    buffers();
    if (failures == 0) {
        printf("all claims hold\n");
    }
    return failures != 0;
}
