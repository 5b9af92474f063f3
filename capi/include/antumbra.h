/*
 * Antumbra: occlusion culling on the CPU, exact and deterministic. Which objects of this scene can this camera see?
 *
 * There are two ways in. AntumbraCuller owns a scene, from a file (antumbra_scene_load) or from memory
 * (antumbra_scene_builder_create), and gives the visible objects of frame after frame (antumbra_culler_cull).
 * AntumbraOcclusionBuffer is for engines with a scene of their own: it is drawn into, and asked about boxes.
 *
 * Conventions
 *   World coordinates are right-handed, in any unit; x, y and z are three numbers in this order. Matrices have 16 numbers,
 *   column by column, and take column vectors. Fronts are counter-clockwise. Pixels are counted from the upper left corner.
 *   Strings are UTF-8 and end with a NUL.
 *
 * Errors
 *   A function that can fail returns an AntumbraStatus; antumbra_last_error has a sentence about it. Whatever a program hands over
 *   of numbers, indices, sizes and NULL ends in an error and, unless another thing is said, leaves all as it was. A pointer that must not be NULL and is
 *   ends in ANTUMBRA_ERROR_NULL_POINTER; which may be NULL is said. Nothing unwinds into the caller. What cannot be checked and
 *   is asked of the caller: pointers point to as much memory as is said, of their type and aligned to it; a handle is used after
 *   its creation and before its destruction; places for results do not overlap anything else of the call. If there is no memory left,
 *   the program ends.
 *
 * Ownership
 *   What is created is destroyed by the function that is named there, once, by any thread. What is passed in is copied or no longer
 *   needed when the call returns. What a function gives as a pointer to const belongs to its handle, as long as is said there.
 *
 * Threads
 *   Handles have nothing in common, and the last error is each thread's own. Of one handle, calls that take it as const may run at
 *   the same time on any number of threads; a call that takes it as not const needs it for itself, and two calls that collide are
 *   told so (ANTUMBRA_ERROR_BUSY): nobody waits. A handle may go from thread to thread. Not to destroy a handle while it is in use, and
 *   not to read a list that belongs to it while another call changes it, is up to the caller.
 *
 * The same calls give the same answers on every machine, at every level, for any number of threads, unless a budget of time is set.
 *
 * This file is made by cbindgen from capi/src: change it there.
 */

#ifndef ANTUMBRA_H
#define ANTUMBRA_H

#include <stddef.h>
#include <stdint.h>

/**
 * The header's version: programs for one major version run with every library of that version.
 */
#define ANTUMBRA_VERSION_MAJOR 0

/**
 * Grows with what is added. While the major version is 0, what is there may change with it too.
 */
#define ANTUMBRA_VERSION_MINOR 1

/**
 * Grows with what is mended.
 */
#define ANTUMBRA_VERSION_PATCH 0

/**
 * The most triangles that a cluster has.
 */
#define ANTUMBRA_TRIANGLES_PER_CLUSTER 64

/**
 * How a call ended. Later versions may have more errors than these.
 */
typedef enum {
    /**
     * All went well.
     */
    ANTUMBRA_OK = 0,
    /**
     * A pointer that has to point to something is NULL.
     */
    ANTUMBRA_ERROR_NULL_POINTER = 1,
    /**
     * An argument makes no sense: a number that is not finite or out of its range, a value that no list has, a matrix that is not
     * affine, indices without vertices.
     */
    ANTUMBRA_ERROR_INVALID_ARGUMENT = 2,
    /**
     * There is no object, mesh, cluster, frame or pixel of that number.
     */
    ANTUMBRA_ERROR_OUT_OF_RANGE = 3,
    /**
     * The size of a struct is none that this version knows.
     */
    ANTUMBRA_ERROR_STRUCT_SIZE = 4,
    /**
     * A string is not UTF-8.
     */
    ANTUMBRA_ERROR_UTF8 = 5,
    /**
     * A file cannot be read or written.
     */
    ANTUMBRA_ERROR_IO = 6,
    /**
     * A file is damaged, of an unknown kind or version, or asks for what is not built in.
     */
    ANTUMBRA_ERROR_FILE = 7,
    /**
     * A scene built in memory makes no sense: the message names the mesh or object and the cause.
     */
    ANTUMBRA_ERROR_SCENE = 8,
    /**
     * The call comes at the wrong time: drawing after the end of drawing, asking before the first frame.
     */
    ANTUMBRA_ERROR_STATE = 9,
    /**
     * Another thread is using the handle, and one of the two calls changes it. Nothing was done.
     */
    ANTUMBRA_ERROR_BUSY = 10,
    /**
     * The operating system gives no threads.
     */
    ANTUMBRA_ERROR_THREADS = 11,
    /**
     * This machine or build lacks the instruction set.
     */
    ANTUMBRA_ERROR_LEVEL = 12,
    /**
     * A fault in Antumbra itself: please report it, with the message. A handle that was being changed is broken from then on.
     */
    ANTUMBRA_ERROR_INTERNAL = 13,
    /**
     * The handle is broken: an earlier call on it ended with ANTUMBRA_ERROR_INTERNAL. It can only be destroyed.
     */
    ANTUMBRA_ERROR_BROKEN = 14,
} AntumbraStatus;

/**
 * How space is projected.
 */
typedef enum {
    /**
     * Everything meets in the eye. Depth is near / distance: 1 at the near plane, 0 infinitely far.
     */
    ANTUMBRA_PERSPECTIVE = 0,
    /**
     * Everything moves along the view. Depth is -distance.
     */
    ANTUMBRA_ORTHOGRAPHIC = 1,
} AntumbraProjectionKind;

/**
 * What may be lost.
 */
typedef enum {
    /**
     * Nothing that owns a pixel is ever culled.
     */
    ANTUMBRA_EXACT = 0,
    /**
     * Small holes between occluders are ignored, and what shows only through them is culled: see AntumbraApproximation.
     */
    ANTUMBRA_APPROXIMATE = 1,
} AntumbraAccuracy;

/**
 * How occluders are chosen.
 */
typedef enum {
    /**
     * The clusters that the frames before needed, and what closes the gaps between them.
     */
    ANTUMBRA_SELECT_CONTRIBUTION = 0,
    /**
     * The nearest objects.
     */
    ANTUMBRA_SELECT_NEAREST = 1,
    /**
     * Those that begin nearest along the view.
     */
    ANTUMBRA_SELECT_Z_PLANE = 2,
    /**
     * Those that look largest.
     */
    ANTUMBRA_SELECT_SOLID_ANGLE = 3,
    /**
     * Those that fill their boxes, are large, near and turned towards the eye.
     */
    ANTUMBRA_SELECT_WEIGHT = 4,
    /**
     * Of those that were visible in the last frame or the one before, the nearest.
     */
    ANTUMBRA_SELECT_PREVIOUS_VISIBLE = 5,
    /**
     * The nearest of those and of what has entered the frustum.
     */
    ANTUMBRA_SELECT_COHERENT = 6,
    /**
     * The clusters that are seen from the nearest viewpoint of a grid, if the scene is from an archive that has one.
     */
    ANTUMBRA_SELECT_SAMPLED = 7,
} AntumbraSelection;

/**
 * How many triangles may be drawn as occluders in a frame.
 */
typedef enum {
    /**
     * As many as pay, by counted work: the same on any machine.
     */
    ANTUMBRA_BUDGET_AUTO = 0,
    /**
     * Every candidate's.
     */
    ANTUMBRA_BUDGET_ALL = 1,
    /**
     * At most AntumbraSettings.budget_amount.
     */
    ANTUMBRA_BUDGET_TRIANGLES = 2,
    /**
     * As many as pay, until AntumbraSettings.budget_amount nanoseconds have gone by since the frame began. This is the one setting by which
     * a result depends on the machine: how much is culled, never whether that is right.
     */
    ANTUMBRA_BUDGET_TIME = 3,
} AntumbraBudget;

/**
 * What is kept of the depth of occluders.
 */
typedef enum {
    /**
     * The depth of the nearest surfaces in each half of a tile.
     */
    ANTUMBRA_DEPTH_NO_BACKGROUND = 0,
    /**
     * The farthest depth of all that is drawn.
     */
    ANTUMBRA_DEPTH_PLANE = 1,
    /**
     * The farthest depth in each of 64x64 cells.
     */
    ANTUMBRA_DEPTH_ESTIMATION = 2,
    /**
     * A Z-buffer under a pyramid of farthest values: see AntumbraSettings.nth.
     */
    ANTUMBRA_DEPTH_HIERARCHICAL = 3,
} AntumbraDepth;

/**
 * What makes objects unfit to be occluders, whatever the eye sees of them.
 */
typedef enum {
    /**
     * They are small.
     */
    ANTUMBRA_UNFIT_BY_SIZE = 1,
    /**
     * They reach far through the scene, or are drawn out.
     */
    ANTUMBRA_UNFIT_BY_LOCALITY = 2,
    /**
     * They have many triangles for what they can cover.
     */
    ANTUMBRA_UNFIT_BY_COMPLEXITY = 4,
    /**
     * They are attached to something larger that covers them.
     */
    ANTUMBRA_UNFIT_BY_REDUNDANCY = 8,
} AntumbraStaticCriteria;

/**
 * An instruction set for the hot loops. Each gives the same bits.
 */
typedef enum {
    /**
     * The best that the machine has.
     */
    ANTUMBRA_LEVEL_BEST = 0,
    /**
     * None: the plain form that defines every loop.
     */
    ANTUMBRA_LEVEL_SCALAR = 1,
    /**
     * x86-64 with SSE4.2.
     */
    ANTUMBRA_LEVEL_SSE42 = 2,
    /**
     * x86-64 with AVX2.
     */
    ANTUMBRA_LEVEL_AVX2 = 3,
    /**
     * x86-64 with AVX-512.
     */
    ANTUMBRA_LEVEL_AVX512 = 4,
    /**
     * 64-bit Arm.
     */
    ANTUMBRA_LEVEL_NEON = 5,
} AntumbraLevel;

/**
 * How a surface lets light through.
 */
typedef enum {
    /**
     * It hides what is behind it. The only kind that occludes, but for ANTUMBRA_ALPHA_BLEND where AntumbraSettings.translucent is set.
     */
    ANTUMBRA_ALPHA_OPAQUE = 0,
    /**
     * It is cut out by a texture: never an occluder.
     */
    ANTUMBRA_ALPHA_MASK = 1,
    /**
     * It is translucent.
     */
    ANTUMBRA_ALPHA_BLEND = 2,
} AntumbraAlpha;

/**
 * What an object is besides a placed mesh: any of these, or 0.
 */
typedef enum {
    /**
     * Always in the visible set while its box meets the frustum.
     */
    ANTUMBRA_OBJECT_NEVER_CULL = 1,
    /**
     * Never drawn as an occluder.
     */
    ANTUMBRA_OBJECT_NEVER_OCCLUDE = 2,
} AntumbraObjectFlags;

/**
 * Which sides of a triangle are drawn. A front is where its corners run counter-clockwise in local coordinates: a matrix that mirrors
 * does not turn a mesh inside out.
 */
typedef enum {
    /**
     * Backs are left out.
     */
    ANTUMBRA_CULL_BACK = 0,
    /**
     * Fronts are left out.
     */
    ANTUMBRA_CULL_FRONT = 1,
    /**
     * Both sides are drawn.
     */
    ANTUMBRA_CULL_NONE = 2,
} AntumbraCullMode;

/**
 * What kind of answer it is.
 */
typedef enum {
    /**
     * It covers no sample of the picture: it lies outside, or between samples. So it is hidden.
     */
    ANTUMBRA_OUTSIDE = 0,
    /**
     * Nothing of it can reach a pixel: it is hidden.
     */
    ANTUMBRA_OCCLUDED = 1,
    /**
     * Something of it may reach a pixel.
     */
    ANTUMBRA_VISIBLE = 2,
} AntumbraAnswer;

/**
 * What a frame did not do, and why.
 */
typedef enum {
    /**
     * The whole frame: neither the camera nor anything in the scene has changed since the last one, whose answer holds.
     */
    ANTUMBRA_SKIPPED_EVERYTHING = 1,
    /**
     * All of the picture but what objects touch that have moved: nothing else has.
     */
    ANTUMBRA_SKIPPED_ELSEWHERE = 2,
    /**
     * Occlusion: what is in the frustum covers too little of the picture to hide much.
     */
    ANTUMBRA_SKIPPED_LITTLE_COVERS = 4,
    /**
     * Occlusion: in the last frames that tried, what was hidden would have cost less to draw than it cost to find.
     */
    ANTUMBRA_SKIPPED_LITTLE_HIDDEN = 8,
    /**
     * Asking about objects one by one that cost less to draw.
     */
    ANTUMBRA_SKIPPED_DEARER_THAN_DRAWING = 16,
    /**
     * The pyramid of occlusion maps: nothing needs it where no hole may be ignored.
     */
    ANTUMBRA_SKIPPED_PYRAMID = 32,
} AntumbraSkips;

/**
 * The cameras of consecutive frames, from a file. It never changes: any number of threads may use it at once.
 */
typedef struct AntumbraCameraPath AntumbraCameraPath;

/**
 * Culls a scene, frame by frame. What takes it as const may be called by any number of threads at once; what changes it needs it for itself,
 * or ANTUMBRA_ERROR_BUSY comes of it. It has threads of its own, which sleep between frames and have ended when it is destroyed.
 *
 * Lists that a culler gives belong to it. They are valid until the next call that takes the culler as not const.
 */
typedef struct AntumbraCuller AntumbraCuller;

/**
 * What a culler knew of its frames at a time. It never changes: any number of threads may use it at once. It chooses occluders and hides
 * nothing, so to recall what does not fit costs time alone.
 */
typedef struct AntumbraMemory AntumbraMemory;

/**
 * What occluders hide, for engines that have their own scene. A frame is: clear, draw, finish, ask. Questions before finish are answered
 * too, from what is drawn so far.
 *
 * What takes it as const may be called by any number of threads at once; what changes it needs it for itself, or
 * ANTUMBRA_ERROR_BUSY comes of it. It has no threads of its own.
 */
typedef struct AntumbraOcclusionBuffer AntumbraOcclusionBuffer;

/**
 * A scene that is ready for culling. It never changes: any number of threads and cullers may use it at once, and it may be destroyed before
 * the cullers that were made of it.
 */
typedef struct AntumbraScene AntumbraScene;

/**
 * A scene that is being put together: meshes, and objects that place them in the world.
 */
typedef struct AntumbraSceneBuilder AntumbraSceneBuilder;

/**
 * A projection, symmetric about the view: a picture that is moved by parts of a pixel has to be culled without. The picture's size gives
 * the proportions. Distances are in scene units along the view.
 */
typedef struct {
    /**
     * An AntumbraProjectionKind.
     */
    uint32_t kind;
    /**
     * Perspective: the angle between the upper and lower edges of the picture, in radians, between 0 and pi. Orthographic: the height of
     * what the picture shows, in scene units.
     */
    double fov_y_or_height;
    /**
     * Distance of the near plane: above 0 where the projection is perspective.
     */
    double near_plane;
    /**
     * Distance of the far plane, beyond the near one; INFINITY if there is none.
     */
    double far_plane;
} AntumbraProjection;

/**
 * A camera. antumbra_camera_look_at and antumbra_camera_from_view make one. Its axes are unit vectors at right angles, by 1e-6 at the most;
 * what uses a camera checks it.
 */
typedef struct {
    /**
     * Where it stands, world coordinates.
     */
    double eye[3];
    /**
     * To the right of the picture: forward x up.
     */
    double right[3];
    /**
     * To the top of the picture: right x forward.
     */
    double up[3];
    /**
     * Along the view.
     */
    double forward[3];
    /**
     * How it projects.
     */
    AntumbraProjection projection;
} AntumbraCamera;

/**
 * A box along the axes of the world.
 */
typedef struct {
    /**
     * The least coordinates.
     */
    double min[3];
    /**
     * The largest coordinates.
     */
    double max[3];
} AntumbraBox;

/**
 * What a surface is like, as far as culling needs to know.
 */
typedef struct {
    /**
     * An AntumbraAlpha.
     */
    uint32_t alpha;
    /**
     * Whether both sides are drawn: 0 or 1. A single-sided surface is drawn, and occludes, with its front faces only: those whose corners
     * run counter-clockwise in the mesh's own coordinates.
     */
    uint32_t double_sided;
    /**
     * Of a translucent surface: from 0, all light passes, to 1.
     */
    float opacity;
} AntumbraMaterial;

/**
 * Which holes are ignored where accuracy is approximate. antumbra_settings_init fills in the defaults.
 */
typedef struct {
    /**
     * So many uncovered pixels of the picture are ignored in any window of a base cell's size.
     */
    uint32_t hole;
    /**
     * Base cells are 8 * 2^base_level pixels wide, from 0 to 12. Of finer cells nothing is ignored.
     */
    uint32_t base_level;
    /**
     * The coarsest level whose cells are looked at, from 0 to 255.
     */
    uint32_t coarsest_level;
    /**
     * 0.
     */
    uint32_t reserved;
    /**
     * From 1, where the hole's size is a promise, to 4: how favourably holes are assumed to be distributed.
     */
    double distribution;
    /**
     * From 0 to 1: such a share of a base cell's pixels may be covered, and what is behind it is visible without a closer look.
     */
    double transparency;
} AntumbraApproximation;

/**
 * How to cull. antumbra_settings_init fills in the defaults; then width and height have to be set.
 */
typedef struct {
    /**
     * sizeof(AntumbraSettings), set by antumbra_settings_init.
     */
    uint64_t struct_size;
    /**
     * Of the picture, in pixels: from 1 to 16384, any number.
     */
    uint32_t width;
    /**
     * Of the picture, in pixels: from 1 to 16384, any number.
     */
    uint32_t height;
    /**
     * An AntumbraAccuracy.
     */
    uint32_t accuracy;
    /**
     * 0 or 1: whether translucent surfaces are occluders too, whose opacities combine, where accuracy is approximate.
     */
    uint32_t translucent;
    /**
     * Which holes are ignored where accuracy is approximate.
     */
    AntumbraApproximation approximation;
    /**
     * Pixels of the picture along the edge of the occlusion map's: 1, 2 or 4; 0 for what goes well with the accuracy: 1 where it is exact,
     * and 4 where it is approximate. Exact accuracy is exact with any.
     */
    uint32_t map_scale;
    /**
     * An AntumbraSelection.
     */
    uint32_t selection;
    /**
     * An AntumbraBudget.
     */
    uint32_t budget;
    /**
     * Where selection is by contribution: passes of a frame at the most; 0 for as many as pay.
     */
    uint32_t most_passes;
    /**
     * Triangles or nanoseconds, where the budget is one of those.
     */
    uint64_t budget_amount;
    /**
     * AntumbraStaticCriteria, added up; by contribution nothing makes objects unfit.
     */
    uint32_t static_criteria;
    /**
     * Where selection is by what was visible: in which frame, 1 for the last one or 2 for the one before it.
     */
    uint32_t frames_back;
    /**
     * Where selection is by weight: objects that fill their boxes less are no occluders, from 0 to 1.
     */
    float least_compactness;
    /**
     * Where selection is by weight: objects that are drawn at the most; 0 for as many as the budget allows.
     */
    uint32_t most_active;
    /**
     * An AntumbraDepth. With another one than the default, occluders are drawn first, nearest first if they are to be chosen by
     * contribution, and all objects are asked after. With a map that is coarser than the picture it is the default one.
     */
    uint32_t depth;
    /**
     * Where depth is hierarchical and accuracy approximate: the nth farthest value stands for a cell, and nth - 1 samples are
     * ignored; from 1 to 64.
     */
    uint32_t nth;
    /**
     * Threads to use: 1 is the caller's own; several are the culler's, and the caller waits for them; 0 for as many as the machine runs at
     * once, up to 1024. The visible set is the same for any number.
     */
    uint32_t threads;
    /**
     * An AntumbraLevel. The visible set is the same for any.
     */
    uint32_t level;
    /**
     * 0 or 1: whether a frame takes from the last one's answer what still holds: all of it where neither the camera nor the scene has
     * changed, and all but what they touch where a few objects have moved. A budget of time has every frame find out everything.
     */
    uint32_t reuse;
    /**
     * 0 or 1: whether a frame does without occlusion where looking for what is hidden costs more than drawing it, and does not ask about
     * objects that cost less to draw. Only where selection is by contribution.
     */
    uint32_t skip;
    /**
     * What it costs to draw an object, without its triangles, in nanoseconds: a draw call. Not negative.
     */
    double object_price_ns;
    /**
     * What it costs to draw a triangle, in nanoseconds. Not negative.
     */
    double triangle_price_ns;
    /**
     * How far the final pass may draw beside where this library would, so that culling is exact for it too: in pixels of the picture, from
     * 0 to 4. 0 for a picture by this library; 0.125 for a graphics processor with one sample in the middle of each pixel, and 1
     * where samples may lie anywhere in it (docs/gpu.md).
     */
    double slack_pixels;
    /**
     * Likewise how far off its positions may be, as a share of their distance, from 0 to 0.5: 4.76837158203125e-7 for 32-bit floats.
     */
    double slack_position;
    /**
     * Likewise how far off its depths may be, as a share of the depth buffer's range, from 0 to 1: 2.384185791015625e-7 for 24 bits.
     */
    double slack_depth;
} AntumbraSettings;

/**
 * Where an object goes.
 */
typedef struct {
    /**
     * The object.
     */
    uint32_t object;
    /**
     * 0 or 1: whether its box is to hold it where it was as well, for who draws it in between: a picture that is late, or blurred by
     * motion. Until its next move it hides nothing then, since nobody knows where it is.
     */
    uint32_t swept;
    /**
     * From its mesh's local coordinates to the world's, from now on: 16 numbers, column by column, whose last row is 0 0 0 1.
     */
    double world_from_local[16];
} AntumbraMove;

/**
 * Counts and times of one frame. Later versions may have more fields at the end.
 */
typedef struct {
    /**
     * Objects that are not culled.
     */
    uint64_t objects_visible;
    /**
     * Occluder candidates that were asked before being drawn.
     */
    uint64_t occluders_asked;
    /**
     * Triangles of the clusters that were drawn as occluders, before clipping and culling by facing.
     */
    uint64_t occluder_triangles;
    /**
     * Clusters that were drawn because the last frame needed them.
     */
    uint64_t clusters_remembered;
    /**
     * Objects that showed themselves after that and were not seen before.
     */
    uint64_t objects_in_question;
    /**
     * Passes over these, each of which drew what might hide some of them.
     */
    uint64_t passes;
    /**
     * Boxes of inner nodes of the hierarchy that were tested.
     */
    uint64_t nodes_tested;
    /**
     * Boxes of inner nodes that were hidden, and ended their subtrees.
     */
    uint64_t nodes_hidden;
    /**
     * Objects that were asked by their rectangles.
     */
    uint64_t objects_asked;
    /**
     * Of these, those that were hidden, and all objects below hidden nodes, in the frustum or not.
     */
    uint64_t objects_hidden;
    /**
     * Boxes of objects that were tested more closely.
     */
    uint64_t objects_tested;
    /**
     * Pixels of holes that approximate accuracy ignored.
     */
    uint64_t ignored_pixels;
    /**
     * The steps that the frame skipped: AntumbraSkips, added up.
     */
    uint64_t skipped;
    /**
     * Nanoseconds for frustum culling, and choosing and sorting occluders. The four times together are the whole frame.
     */
    uint64_t select_ns;
    /**
     * Nanoseconds for asking and drawing occluders.
     */
    uint64_t raster_ns;
    /**
     * Nanoseconds for ending the drawing.
     */
    uint64_t pyramid_ns;
    /**
     * Nanoseconds for testing boxes down the hierarchy.
     */
    uint64_t test_ns;
} AntumbraStatistics;

/**
 * The answer to a question.
 */
typedef struct {
    /**
     * An AntumbraAnswer.
     */
    uint32_t answer;
    /**
     * About what share of it may be seen: more than 0 and up to 1 where it is visible, 0 where it is hidden.
     */
    float level;
} AntumbraVisibility;

/**
 * A cluster of an object: up to ANTUMBRA_TRIANGLES_PER_CLUSTER of its triangles that lie close together.
 */
typedef struct {
    /**
     * The object.
     */
    uint32_t object;
    /**
     * Which of the object's clusters, counted from 0.
     */
    uint32_t cluster;
} AntumbraCluster;

/**
 * A cluster that was drawn as an occluder.
 */
typedef struct {
    /**
     * Which.
     */
    AntumbraCluster cluster;
    /**
     * Its triangles, before clipping and culling by facing.
     */
    uint32_t triangles;
    /**
     * How many samples it took over from what was drawn before it.
     */
    uint32_t gain;
} AntumbraDrawnCluster;

/**
 * Something to draw into an occlusion buffer. Nothing of it is needed after the call.
 */
typedef struct {
    /**
     * x, y and z of each vertex, local units. Triangles with a vertex that is not finite hide nothing.
     */
    const float *positions;
    /**
     * How many vertices there are.
     */
    size_t vertex_count;
    /**
     * Bytes from one vertex to the next: a multiple of 4, at least 12.
     */
    size_t stride;
    /**
     * Three vertices a triangle, counter-clockwise at the front.
     */
    const uint32_t *indices;
    /**
     * How many indices there are: a multiple of 3.
     */
    size_t index_count;
    /**
     * 16 numbers, column by column, whose last row is 0 0 0 1; it may mirror and scale unevenly; NULL for the identity. Answers are
     * exact as long as local coordinates, times the matrix's scale, and its translation are not a thousand times larger than the world
     * coordinates that they cancel to.
     */
    const double *world_from_local;
    /**
     * An AntumbraCullMode.
     */
    uint32_t cull_mode;
} AntumbraOccluder;

/**
 * A box with any orientation, world coordinates. Its axes need not be at right angles to each other.
 */
typedef struct {
    /**
     * The middle.
     */
    double center[3];
    /**
     * From the middle to the middles of three faces.
     */
    double half_axes[3][3];
} AntumbraOrientedBox;

#ifdef __cplusplus
extern "C" {
#endif // __cplusplus

/**
 * The library's version, such as "0.1.0"; valid forever. It can differ from the header's ANTUMBRA_VERSION_MAJOR, _MINOR and
 * _PATCH where the library is shared.
 */
const char *antumbra_version(void);

/**
 * What was wrong with the last call on this thread that failed: a sentence in UTF-8 for people, which names the argument, file
 * or object, and what to do. It is empty if none failed yet. It is valid until the next call on this thread that fails, and
 * never NULL.
 */
const char *antumbra_last_error(void);

/**
 * The name of a status, such as "ANTUMBRA_ERROR_FILE"; "unknown" if it has none. Valid forever.
 */
const char *antumbra_status_name(uint32_t status);

/**
 * The best level of this machine: an AntumbraLevel, never ANTUMBRA_LEVEL_BEST itself.
 */
uint32_t antumbra_best_level(void);

/**
 * Makes a camera at a point that looks at another one. Coordinates are right-handed.
 *
 * @param eye, target, up Three numbers each, world coordinates. up, of any length, points upwards in the picture.
 *
 * Errors: ANTUMBRA_ERROR_INVALID_ARGUMENT if a number is not finite, eye and target are the same, up points along the view, or
 * the projection is out of range.
 */
AntumbraStatus antumbra_camera_look_at(const double *eye,
                                       const double *target,
                                       const double *up,
                                       const AntumbraProjection *projection,
                                       AntumbraCamera *camera);

/**
 * Makes a camera of the matrix that leads from world coordinates to those of the view: x to the right, y upwards, z backwards.
 *
 * @param view_from_world 16 numbers, column by column; a rotation and a translation. What it lacks of right angles and unit
 *     lengths, as a matrix that was computed in single precision does, is mended.
 *
 * Errors: ANTUMBRA_ERROR_INVALID_ARGUMENT if a number is not finite, the last row is not 0 0 0 1, the upper left part is by more
 * than 1e-3 no rotation, or the projection is out of range.
 */
AntumbraStatus antumbra_camera_from_view(const double *view_from_world,
                                         const AntumbraProjection *projection,
                                         AntumbraCamera *camera);

/**
 * Reads a camera path as the antumbra command takes it: JSON with "fov_y_degrees" (or "height" for an orthographic view),
 * "near", "far" (may be left out: infinite) and "frames" of "eye", "target" and "up".
 *
 * @param file UTF-8.
 * @param path Is given a path, to be destroyed by antumbra_camera_path_destroy; NULL if there is an error.
 *
 * Errors: ANTUMBRA_ERROR_UTF8, ANTUMBRA_ERROR_IO, ANTUMBRA_ERROR_FILE.
 */
AntumbraStatus antumbra_camera_path_load(const char *file,
                                         AntumbraCameraPath **path);

/**
 * Ends a path. NULL is fine.
 */
void antumbra_camera_path_destroy(AntumbraCameraPath *path);

/**
 * How many frames a path has; 0 if path is NULL.
 */
size_t antumbra_camera_path_length(const AntumbraCameraPath *path);

/**
 * The camera of a frame, counted from 0.
 *
 * Errors: ANTUMBRA_ERROR_OUT_OF_RANGE.
 */
AntumbraStatus antumbra_camera_path_frame(const AntumbraCameraPath *path,
                                          size_t frame,
                                          AntumbraCamera *camera);

/**
 * Loads a scene (.glb, .gltf or .obj) and prepares it, which takes seconds for a million triangles; or an archive, which
 * antumbra_scene_save or `antumbra prepare` wrote, in a fraction of that. An object is a node with a mesh, or a group of an OBJ
 * file.
 *
 * @param file UTF-8. An archive is mapped into memory: nobody may write into the file while the scene or a culler of it lives
 *     (to replace it is fine).
 * @param threads How many may work at it, up to 1024; 0 for as many as the machine runs at once. They have ended when the
 *     call has. The result is the same for any number.
 * @param scene Is given a scene, to be destroyed by antumbra_scene_destroy; NULL if there is an error.
 *
 * Errors: ANTUMBRA_ERROR_UTF8, ANTUMBRA_ERROR_IO, ANTUMBRA_ERROR_FILE, ANTUMBRA_ERROR_THREADS.
 */
AntumbraStatus antumbra_scene_load(const char *file,
                                   uint32_t threads,
                                   AntumbraScene **scene);

/**
 * Writes an archive of a scene. A file of that name is replaced when all is written, and stays as it is if that fails. The same
 * scene gives the same bytes on every machine.
 *
 * @param file UTF-8; by custom it ends in .antumbra.
 *
 * Errors: ANTUMBRA_ERROR_UTF8, ANTUMBRA_ERROR_IO.
 */
AntumbraStatus antumbra_scene_save(const AntumbraScene *scene,
                                   const char *file);

/**
 * Ends a scene. NULL is fine. Cullers that were made of it go on.
 */
void antumbra_scene_destroy(AntumbraScene *scene);

/**
 * How many objects a scene has, which are numbered from 0 in the order of their file or of antumbra_scene_builder_add_object; 0
 * if scene is NULL.
 */
uint32_t antumbra_scene_object_count(const AntumbraScene *scene);

/**
 * How many triangles a scene has, a shared mesh counted once for each object that places it; 0 if scene is NULL.
 */
uint64_t antumbra_scene_triangle_count(const AntumbraScene *scene);

/**
 * The name of an object in its file, or one made from its place there. UTF-8, valid as long as the scene.
 *
 * Errors: ANTUMBRA_ERROR_OUT_OF_RANGE.
 */
AntumbraStatus antumbra_scene_object_name(const AntumbraScene *scene, uint32_t object, const char **name);

/**
 * The world box of an object: what is asked about when it is culled.
 *
 * Errors: ANTUMBRA_ERROR_OUT_OF_RANGE.
 */
AntumbraStatus antumbra_scene_object_bounds(const AntumbraScene *scene, uint32_t object, AntumbraBox *bounds);

/**
 * How many sentences there are about what in the file was understood but could not be used; 0 if scene is NULL.
 */
size_t antumbra_scene_warning_count(const AntumbraScene *scene);

/**
 * One of these sentences, counted from 0. UTF-8, valid as long as the scene.
 *
 * Errors: ANTUMBRA_ERROR_OUT_OF_RANGE.
 */
AntumbraStatus antumbra_scene_warning(const AntumbraScene *scene, size_t index, const char **warning);

/**
 * Begins a scene.
 *
 * @param builder Is given a builder, to be destroyed by antumbra_scene_builder_destroy; NULL if there is an error.
 */
AntumbraStatus antumbra_scene_builder_create(AntumbraSceneBuilder **builder);

/**
 * Ends a builder. NULL is fine. Scenes that it built go on.
 */
void antumbra_scene_builder_destroy(AntumbraSceneBuilder *builder);

/**
 * Adds a mesh: positions, which are copied. antumbra_scene_builder_add_surface gives it triangles.
 *
 * @param positions x, y and z of each vertex, local units, stride bytes from one to the next; a multiple of 4, at least 12.
 * @param mesh Is given the mesh's number, counted from 0.
 *
 * Errors: ANTUMBRA_ERROR_INVALID_ARGUMENT if there is no such stride. Numbers that are not finite are found by
 * antumbra_scene_builder_build.
 */
AntumbraStatus antumbra_scene_builder_add_mesh(AntumbraSceneBuilder *builder,
                                               const float *positions,
                                               size_t vertex_count,
                                               size_t stride,
                                               uint32_t *mesh);

/**
 * Adds triangles of one material to a mesh.
 *
 * @param indices Three vertices of the mesh each, counter-clockwise at the front; copied.
 * @param material NULL for an opaque, single-sided one.
 *
 * Errors: ANTUMBRA_ERROR_OUT_OF_RANGE if there is no such mesh or vertex, ANTUMBRA_ERROR_INVALID_ARGUMENT if index_count is no
 * multiple of 3 or there is no such material.
 */
AntumbraStatus antumbra_scene_builder_add_surface(AntumbraSceneBuilder *builder,
                                                  uint32_t mesh,
                                                  const uint32_t *indices,
                                                  size_t index_count,
                                                  const AntumbraMaterial *material);

/**
 * Adds an object: a mesh, placed in the world. It is the unit that is culled or kept.
 *
 * @param world_from_local 16 numbers, column by column, whose last row is 0 0 0 1; it may mirror and scale unevenly; NULL for
 *     the identity.
 * @param flags AntumbraObjectFlags, added up.
 * @param object Is given the object's number, counted from 0; may be NULL.
 *
 * Errors: ANTUMBRA_ERROR_OUT_OF_RANGE if there is no such mesh, ANTUMBRA_ERROR_INVALID_ARGUMENT if the matrix is not finite and
 * affine or there is no such flag.
 */
AntumbraStatus antumbra_scene_builder_add_object(AntumbraSceneBuilder *builder,
                                                 uint32_t mesh,
                                                 const double *world_from_local,
                                                 uint32_t flags,
                                                 uint32_t *object);

/**
 * Names an object; messages and antumbra_scene_object_name have the name.
 *
 * @param name UTF-8, copied.
 *
 * Errors: ANTUMBRA_ERROR_OUT_OF_RANGE, ANTUMBRA_ERROR_UTF8.
 */
AntumbraStatus antumbra_scene_builder_set_object_name(AntumbraSceneBuilder *builder,
                                                      uint32_t object,
                                                      const char *name);

/**
 * Draws another mesh in place of an object's own where it is an occluder, in the same local coordinates. Culling is exact only
 * if the proxy lies inside the object, whose surface is opaque and closed, and so deep that snapping (1/256 of a pixel) does not
 * bring its outline out.
 *
 * Errors: ANTUMBRA_ERROR_OUT_OF_RANGE if there is no such object or mesh.
 */
AntumbraStatus antumbra_scene_builder_set_occluder_proxy(AntumbraSceneBuilder *builder,
                                                         uint32_t object,
                                                         uint32_t mesh);

/**
 * Builds the scene and prepares it, which takes seconds for a million triangles. The builder is empty then, also if
 * the scene makes no sense: another one can be begun with it.
 *
 * @param threads How many may work at it, up to 1024; 0 for as many as the machine runs at once. They have ended when the
 *     call has. The result is the same for any number.
 * @param scene Is given a scene, to be destroyed by antumbra_scene_destroy; NULL if there is an error.
 *
 * Errors: ANTUMBRA_ERROR_SCENE if a position is not finite, an object's mesh has no triangles or reaches beyond coordinates of
 * 2^100, or there is no object; ANTUMBRA_ERROR_THREADS.
 */
AntumbraStatus antumbra_scene_builder_build(AntumbraSceneBuilder *builder,
                                            uint32_t threads,
                                            AntumbraScene **scene);

/**
 * Fills in the defaults: exact, by contribution, with a budget chosen by counted work, on all threads, at the best level. What
 * remains to be set are width and height.
 *
 * @param struct_size sizeof(AntumbraSettings).
 *
 * Errors: ANTUMBRA_ERROR_STRUCT_SIZE.
 */
AntumbraStatus antumbra_settings_init(AntumbraSettings *settings,
                                      size_t struct_size);

/**
 * Fills in the default approximation: 64 pixels in any window of 8x8, distributed favourably (2).
 */
AntumbraStatus antumbra_approximation_init(AntumbraApproximation *approximation);

/**
 * Makes a culler.
 *
 * @param scene May be destroyed before the culler.
 * @param culler Is given a culler, to be destroyed by antumbra_culler_destroy; NULL if there is an error.
 *
 * Errors: ANTUMBRA_ERROR_STRUCT_SIZE, ANTUMBRA_ERROR_INVALID_ARGUMENT if a setting makes no sense, ANTUMBRA_ERROR_LEVEL,
 * ANTUMBRA_ERROR_THREADS.
 */
AntumbraStatus antumbra_culler_create(const AntumbraScene *scene,
                                      const AntumbraSettings *settings,
                                      AntumbraCuller **culler);

/**
 * Makes another culler for the same scene as it is now, with other settings and nothing remembered, for another view. What is known of the
 * scene is shared; either may be destroyed first.
 *
 * Errors: as antumbra_culler_create.
 */
AntumbraStatus antumbra_culler_another(const AntumbraCuller *culler,
                                       const AntumbraSettings *settings,
                                       AntumbraCuller **another);

/**
 * Ends a culler and its threads. NULL is fine. Not to be called while another call has the culler.
 */
void antumbra_culler_destroy(AntumbraCuller *culler);

/**
 * Finds which objects a camera may see.
 *
 * @param objects Is given the visible objects in ascending order; NULL if there are none, or an error.
 * @param count Is given how many.
 *
 * Frames follow each other: a frame remembers which occluders the last one needed. Where accuracy is exact, every object that
 * owns a pixel of the picture is in the list. A frame like the last one allocates nothing on one thread.
 *
 * Errors: ANTUMBRA_ERROR_INVALID_ARGUMENT if the camera is none, ANTUMBRA_ERROR_BUSY.
 */
AntumbraStatus antumbra_culler_cull(AntumbraCuller *culler,
                                    const AntumbraCamera *camera,
                                    const uint32_t **objects,
                                    size_t *count);

/**
 * Finds which objects are in a camera's frustum, those that culling chooses from, in ascending order. (A frame does not look at
 * all of them.)
 *
 * Errors: as antumbra_culler_cull.
 */
AntumbraStatus antumbra_culler_in_frustum(AntumbraCuller *culler,
                                          const AntumbraCamera *camera,
                                          const uint32_t **objects,
                                          size_t *count);

/**
 * About what share of each visible object of the last frame may be seen, more than 0 and up to 1, in their order: where a
 * coarser model would do.
 *
 * Errors: ANTUMBRA_ERROR_STATE if nothing has been culled yet, ANTUMBRA_ERROR_BUSY.
 */
AntumbraStatus antumbra_culler_visibility_levels(AntumbraCuller *culler,
                                                 const float **levels,
                                                 size_t *count);

/**
 * The objects that the last frame found visible and that were in the frustum, but not visible, when this was called before:
 * hints for fading them in. To be called once after each antumbra_culler_cull; the first call gives none.
 *
 * Errors: ANTUMBRA_ERROR_STATE if nothing has been culled yet, ANTUMBRA_ERROR_BUSY.
 */
AntumbraStatus antumbra_culler_appearances(AntumbraCuller *culler,
                                           const uint32_t **objects,
                                           size_t *count);

/**
 * Moves objects, occluders among them: from the next frame on they are where they go, in every way, for this culler alone.
 * antumbra_scene_object_bounds tells where they were. The first call copies the scene, but for its meshes.
 *
 * Errors: ANTUMBRA_ERROR_OUT_OF_RANGE if there is no such object, ANTUMBRA_ERROR_INVALID_ARGUMENT if a matrix is not finite and affine,
 * ANTUMBRA_ERROR_SCENE if one leads beyond coordinates of 2^100, ANTUMBRA_ERROR_BUSY. Nothing has moved then.
 */
AntumbraStatus antumbra_culler_move_objects(AntumbraCuller *culler,
                                            const AntumbraMove *moves,
                                            size_t count);

/**
 * Makes pictures of another size from the next frame on. What is remembered stays.
 *
 * @param width, height In pixels, from 1 to 16384.
 *
 * Errors: ANTUMBRA_ERROR_INVALID_ARGUMENT if the size is none, ANTUMBRA_ERROR_BUSY.
 */
AntumbraStatus antumbra_culler_resize(AntumbraCuller *culler, uint32_t width, uint32_t height);

/**
 * Says how much an object stands out against what may hide it, from 0, as at first, to 1: a lamp behind leaves. Where holes are
 * ignored, such an object is culled only if it shows in no more than a share of 1 - salience of what may be ignored in a tile.
 *
 * Errors: ANTUMBRA_ERROR_OUT_OF_RANGE if there is no such object, ANTUMBRA_ERROR_INVALID_ARGUMENT if salience is not from 0 to
 * 1, ANTUMBRA_ERROR_BUSY.
 */
AntumbraStatus antumbra_culler_set_salience(AntumbraCuller *culler,
                                            uint32_t object,
                                            float salience);

/**
 * What the last frame did and what it took.
 *
 * @param struct_size sizeof(AntumbraStatistics). Fields that this version of the library does not have become 0.
 *
 * Errors: ANTUMBRA_ERROR_STATE if nothing has been culled yet, ANTUMBRA_ERROR_BUSY.
 */
AntumbraStatus antumbra_culler_statistics(const AntumbraCuller *culler,
                                          AntumbraStatistics *statistics,
                                          size_t struct_size);

/**
 * Asks whether world boxes are hidden by what the last frame drew: things that are not in the scene because they move. What is
 * asked is what that frame's camera sees.
 *
 * @param boxes, visibilities count of each; they must not overlap. A box that reaches the near plane, or is not finite, is
 *     visible.
 *
 * Errors: ANTUMBRA_ERROR_STATE if nothing has been culled yet, ANTUMBRA_ERROR_BUSY.
 */
AntumbraStatus antumbra_culler_test_boxes(const AntumbraCuller *culler,
                                          const AntumbraBox *boxes,
                                          size_t count,
                                          AntumbraVisibility *visibilities);

/**
 * A hash of what the last frame drew, coverage and depths: the same on every machine.
 *
 * Errors: ANTUMBRA_ERROR_STATE if nothing has been culled yet, ANTUMBRA_ERROR_BUSY.
 */
AntumbraStatus antumbra_culler_buffer_hash(const AntumbraCuller *culler, uint64_t *hash);

/**
 * Finds which clusters of the last frame's visible objects may be seen: an object that reaches everywhere may be visible while
 * most of its clusters are not.
 *
 * @param clusters Is given them, in the order of their objects.
 * @param whole_objects Is given the objects that are to be drawn as a whole, since there is more to them than clusters: they are
 *     translucent or cut out, hide nothing, or have a proxy in their place. Exact if culling is: every cluster that owns a pixel
 *     is named.
 *
 * A frame that leaves occlusion out names all clusters: who draws by clusters sets AntumbraSettings.skip to 0.
 *
 * Errors: ANTUMBRA_ERROR_STATE if nothing has been culled yet, ANTUMBRA_ERROR_BUSY.
 */
AntumbraStatus antumbra_culler_visible_clusters(AntumbraCuller *culler,
                                                const AntumbraCluster **clusters,
                                                size_t *cluster_count,
                                                const uint32_t **whole_objects,
                                                size_t *whole_object_count);

/**
 * The clusters that the last frame drew as occluders, in that order. Some may be of objects that were found hidden after.
 *
 * Errors: ANTUMBRA_ERROR_STATE if nothing has been culled yet, ANTUMBRA_ERROR_BUSY.
 */
AntumbraStatus antumbra_culler_drawn_clusters(AntumbraCuller *culler,
                                              const AntumbraDrawnCluster **clusters,
                                              size_t *count);

/**
 * Copies the triangles of a cluster, those of the proxy if its object has one.
 *
 * @param corners Room for capacity triangles of three corners each, nine numbers: x, y and z of each corner, local units of the
 *     object's mesh, counter-clockwise at the front. ANTUMBRA_TRIANGLES_PER_CLUSTER are always enough.
 * @param triangle_count Is given how many triangles the cluster has; no more than capacity are copied.
 *
 * Errors: ANTUMBRA_ERROR_OUT_OF_RANGE if there is no such object or cluster, ANTUMBRA_ERROR_BUSY.
 */
AntumbraStatus antumbra_culler_cluster_triangles(const AntumbraCuller *culler,
                                                 AntumbraCluster cluster,
                                                 float *corners,
                                                 size_t capacity,
                                                 size_t *triangle_count);

/**
 * Forgets all frames: the next one is as the first.
 *
 * Errors: ANTUMBRA_ERROR_BUSY.
 */
AntumbraStatus antumbra_culler_forget(AntumbraCuller *culler);

/**
 * Keeps what a culler knows of its frames: for views that take turns, or to cull a frame again.
 *
 * @param memory Is given a memory, to be destroyed by antumbra_memory_destroy; NULL if there is an error.
 *
 * Errors: ANTUMBRA_ERROR_BUSY.
 */
AntumbraStatus antumbra_culler_remember(const AntumbraCuller *culler, AntumbraMemory **memory);

/**
 * Goes back to what was known at a time, by this culler or another one of the same AntumbraScene.
 *
 * Errors: ANTUMBRA_ERROR_INVALID_ARGUMENT if the memory is of another scene, ANTUMBRA_ERROR_BUSY.
 */
AntumbraStatus antumbra_culler_recall(AntumbraCuller *culler, const AntumbraMemory *memory);

/**
 * Ends a memory. NULL is fine.
 */
void antumbra_memory_destroy(AntumbraMemory *memory);

/**
 * Makes an empty buffer for pictures of a size, seen by a camera, at the best level, exact.
 *
 * @param width, height Of the picture in pixels, from 1 to 16384.
 * @param map_scale How many of its pixels lie along the edge of the map's, 1, 2 or 4; coarse maps take less time and memory, and
 *     hide less; 0 for 1.
 * @param buffer Is given a buffer, to be destroyed by antumbra_occlusion_buffer_destroy; NULL if there is an error.
 *
 * Errors: ANTUMBRA_ERROR_INVALID_ARGUMENT if the size, the scale or the camera is none.
 */
AntumbraStatus antumbra_occlusion_buffer_create(uint32_t width,
                                                uint32_t height,
                                                uint32_t map_scale,
                                                const AntumbraCamera *camera,
                                                AntumbraOcclusionBuffer **buffer);

/**
 * Ends a buffer. NULL is fine. Not to be called while another call has the buffer.
 */
void antumbra_occlusion_buffer_destroy(AntumbraOcclusionBuffer *buffer);

/**
 * Sets what may be lost, before anything is drawn.
 *
 * @param approximation NULL for exact accuracy, as at first.
 *
 * Errors: ANTUMBRA_ERROR_STATE if something has been drawn since the last antumbra_occlusion_buffer_clear,
 * ANTUMBRA_ERROR_INVALID_ARGUMENT, ANTUMBRA_ERROR_BUSY.
 */
AntumbraStatus antumbra_occlusion_buffer_set_approximation(AntumbraOcclusionBuffer *buffer,
                                                           const AntumbraApproximation *approximation);

/**
 * Chooses the instruction set, an AntumbraLevel. Answers are the same for any.
 *
 * Errors: ANTUMBRA_ERROR_LEVEL, ANTUMBRA_ERROR_INVALID_ARGUMENT, ANTUMBRA_ERROR_BUSY.
 */
AntumbraStatus antumbra_occlusion_buffer_set_level(AntumbraOcclusionBuffer *buffer, uint32_t level);

/**
 * Forgets all that was drawn and begins a frame.
 *
 * Errors: ANTUMBRA_ERROR_INVALID_ARGUMENT if the camera is none, ANTUMBRA_ERROR_BUSY.
 */
AntumbraStatus antumbra_occlusion_buffer_clear(AntumbraOcclusionBuffer *buffer, const AntumbraCamera *camera);

/**
 * Draws an opaque occluder.
 *
 * Errors: ANTUMBRA_ERROR_STATE after antumbra_occlusion_buffer_finish, ANTUMBRA_ERROR_OUT_OF_RANGE if an index has no vertex,
 * ANTUMBRA_ERROR_INVALID_ARGUMENT, ANTUMBRA_ERROR_BUSY. Nothing is drawn then.
 */
AntumbraStatus antumbra_occlusion_buffer_draw(AntumbraOcclusionBuffer *buffer,
                                              const AntumbraOccluder *occluder);

/**
 * Draws an occluder that lets light through. Several of them combine, and where what they let through may be ignored, what is
 * behind the farthest of them is hidden. Where accuracy is exact, this does nothing.
 *
 * @param opacity From 0, all light passes, to 1.
 *
 * Errors: as antumbra_occlusion_buffer_draw.
 */
AntumbraStatus antumbra_occlusion_buffer_draw_translucent(AntumbraOcclusionBuffer *buffer,
                                                          const AntumbraOccluder *occluder,
                                                          float opacity);

/**
 * Ends drawing: covers the holes that may be ignored. To end it again changes nothing.
 *
 * Errors: ANTUMBRA_ERROR_BUSY.
 */
AntumbraStatus antumbra_occlusion_buffer_finish(AntumbraOcclusionBuffer *buffer);

/**
 * Asks whether world boxes are hidden. One call with many boxes is quicker than many calls.
 *
 * @param boxes, visibilities count of each; they must not overlap. A box that reaches the near plane, or is not finite, is
 *     visible.
 *
 * Errors: ANTUMBRA_ERROR_BUSY.
 */
AntumbraStatus antumbra_occlusion_buffer_test_boxes(const AntumbraOcclusionBuffer *buffer,
                                                    const AntumbraBox *boxes,
                                                    size_t count,
                                                    AntumbraVisibility *visibilities);

/**
 * Asks whether boxes with any orientation are hidden.
 *
 * @param boxes, visibilities count of each; they must not overlap. A box that reaches the near plane, or is not finite, is
 *     visible.
 *
 * Errors: ANTUMBRA_ERROR_BUSY.
 */
AntumbraStatus antumbra_occlusion_buffer_test_oriented_boxes(const AntumbraOcclusionBuffer *buffer,
                                                             const AntumbraOrientedBox *boxes,
                                                             size_t count,
                                                             AntumbraVisibility *visibilities);

/**
 * Asks whether a ball is hidden.
 *
 * @param center Three numbers, world coordinates. A ball that reaches the near plane, or is not finite, is visible.
 *
 * Errors: ANTUMBRA_ERROR_BUSY.
 */
AntumbraStatus antumbra_occlusion_buffer_test_sphere(const AntumbraOcclusionBuffer *buffer,
                                                     const double *center,
                                                     double radius,
                                                     AntumbraVisibility *visibility);

/**
 * Asks whether something is hidden of which only a rectangle on screen is known.
 *
 * @param x, y First and last column and row, two numbers each, in pixels from the upper left corner of the picture, fractions
 *     allowed.
 * @param nearest_distance Of its nearest point along the view, scene units. What is not in order or not beyond the near plane is
 *     visible.
 *
 * Errors: ANTUMBRA_ERROR_BUSY.
 */
AntumbraStatus antumbra_occlusion_buffer_test_rectangle(const AntumbraOcclusionBuffer *buffer,
                                                        const double *x,
                                                        const double *y,
                                                        double nearest_distance,
                                                        AntumbraVisibility *visibility);

/**
 * Copies the depth of what is drawn so far, pixel by pixel, row by row from the upper left corner: no pixel's occluder is
 * farther than that. Depths are the larger the nearer; see AntumbraProjectionKind. Where nothing is drawn it is -INFINITY.
 *
 * @param depths Room for count numbers, which must be width * height.
 *
 * Errors: ANTUMBRA_ERROR_INVALID_ARGUMENT if count is another number, ANTUMBRA_ERROR_BUSY.
 */
AntumbraStatus antumbra_occlusion_buffer_read_depth(const AntumbraOcclusionBuffer *buffer,
                                                    float *depths,
                                                    size_t count);

/**
 * A hash of what is drawn so far, coverage and depths: the same on every machine.
 *
 * Errors: ANTUMBRA_ERROR_BUSY.
 */
AntumbraStatus antumbra_occlusion_buffer_hash(const AntumbraOcclusionBuffer *buffer, uint64_t *hash);

/**
 * How many pixels of the picture are ignored because accuracy is approximate: no other pixel can be wrong, if the map is as
 * large as the picture or the distribution factor is 1.
 *
 * Errors: ANTUMBRA_ERROR_BUSY.
 */
AntumbraStatus antumbra_occlusion_buffer_ignored_pixels(const AntumbraOcclusionBuffer *buffer,
                                                        uint64_t *pixels);

#ifdef __cplusplus
}  // extern "C"
#endif  // __cplusplus

#endif  /* ANTUMBRA_H */
