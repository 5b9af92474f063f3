// An engine that has its own scene: a wall and some boxes, of which the wall hides those behind it. The wall is drawn into an occlusion
// buffer, and several threads ask about the boxes.
//
//     buffer [LEVEL]          a number of AntumbraLevel, 0 for the best
#include <algorithm>
#include <array>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <limits>
#include <memory>
#include <stdexcept>
#include <thread>
#include <vector>

#include "antumbra.h"

namespace {

// An error as an exception, a handle as a unique_ptr: all that C++ needs.
void check(AntumbraStatus status)
{
    if (status != ANTUMBRA_OK) {
        throw std::runtime_error(antumbra_last_error());
    }
}

struct Destroy {
    void operator()(AntumbraOcclusionBuffer *buffer) const { antumbra_occlusion_buffer_destroy(buffer); }
};

class OcclusionBuffer {
public:
    OcclusionBuffer(std::uint32_t width, std::uint32_t height, const AntumbraCamera &camera)
    {
        AntumbraOcclusionBuffer *created = nullptr;
        check(antumbra_occlusion_buffer_create(width, height, 1, &camera, &created));
        handle.reset(created);
    }

    void set_level(std::uint32_t level) { check(antumbra_occlusion_buffer_set_level(handle.get(), level)); }
    void clear(const AntumbraCamera &camera) { check(antumbra_occlusion_buffer_clear(handle.get(), &camera)); }
    void draw(const AntumbraOccluder &occluder) { check(antumbra_occlusion_buffer_draw(handle.get(), &occluder)); }
    void finish() { check(antumbra_occlusion_buffer_finish(handle.get())); }

    // From any number of threads.
    void test(const AntumbraBox *boxes, std::size_t count, AntumbraVisibility *answers) const
    {
        check(antumbra_occlusion_buffer_test_boxes(handle.get(), boxes, count, answers));
    }

private:
    std::unique_ptr<AntumbraOcclusionBuffer, Destroy> handle;
};

// What an engine keeps of a vertex; the interface reads every sixth float onwards.
struct Vertex {
    float position[3];
    float normal[3];
};

AntumbraCamera camera_at(double x)
{
    const double eye[3] = {x, 2.0, 10.0}, target[3] = {x, 2.0, 0.0}, up[3] = {0.0, 1.0, 0.0};
    AntumbraProjection projection = AntumbraProjection();
    projection.kind = ANTUMBRA_PERSPECTIVE;
    projection.fov_y_or_height = 1.0;
    projection.near_plane = 0.1;
    projection.far_plane = std::numeric_limits<double>::infinity();
    AntumbraCamera camera;
    check(antumbra_camera_look_at(eye, target, up, &projection, &camera));
    return camera;
}

// A row of boxes, one unit wide, two units apart.
std::vector<AntumbraBox> row_of_boxes(double z)
{
    std::vector<AntumbraBox> boxes;
    for (int i = -20; i <= 20; i++) {
        const AntumbraBox box = {{i * 2.0 - 0.5, 1.0, z - 0.5}, {i * 2.0 + 0.5, 2.0, z + 0.5}};
        boxes.push_back(box);
    }
    return boxes;
}

std::size_t hidden_of(const OcclusionBuffer &buffer, const std::vector<AntumbraBox> &boxes)
{
    std::vector<AntumbraVisibility> answers(boxes.size());
    const std::size_t threads = 4, share = (boxes.size() + threads - 1) / threads;
    std::vector<std::thread> workers;
    for (std::size_t first = 0; first < boxes.size(); first += share) {
        const std::size_t count = std::min(share, boxes.size() - first);
        workers.emplace_back([&, first, count] { buffer.test(&boxes[first], count, &answers[first]); });
    }
    for (std::thread &worker : workers) {
        worker.join();
    }
    std::size_t hidden = 0;
    for (const AntumbraVisibility &answer : answers) {
        hidden += answer.answer == ANTUMBRA_OCCLUDED;
    }
    return hidden;
}

void run(std::uint32_t level)
{
    const std::array<Vertex, 4> wall = {{
        {{-4, 0, 0}, {0, 0, 1}},
        {{4, 0, 0}, {0, 0, 1}},
        {{4, 4, 0}, {0, 0, 1}},
        {{-4, 4, 0}, {0, 0, 1}},
    }};
    const std::array<std::uint32_t, 6> indices = {{0, 1, 2, 0, 2, 3}};
    AntumbraOccluder occluder = AntumbraOccluder();
    occluder.positions = wall[0].position;
    occluder.vertex_count = wall.size();
    occluder.stride = sizeof(Vertex);
    occluder.indices = indices.data();
    occluder.index_count = indices.size();
    occluder.cull_mode = ANTUMBRA_CULL_BACK;

    OcclusionBuffer buffer(640, 384, camera_at(0.0));
    buffer.set_level(level);
    for (int frame = 0; frame < 3; frame++) {
        // The camera moves sideways, and what the wall hides moves the other way.
        buffer.clear(camera_at(frame * 4.0));
        buffer.draw(occluder);
        buffer.finish();
        std::printf("frame %d: the wall hides %zu boxes behind it, and %zu before it\n", frame,
                    hidden_of(buffer, row_of_boxes(-10.0)), hidden_of(buffer, row_of_boxes(5.0)));
    }
}

}  // namespace

int main(int argc, char **argv)
{
    try {
        run(argc > 1 ? static_cast<std::uint32_t>(std::strtoul(argv[1], nullptr, 10)) : 0);
    } catch (const std::exception &error) {
        std::fprintf(stderr, "error: %s\n", error.what());
        return 1;
    }
    return 0;
}
