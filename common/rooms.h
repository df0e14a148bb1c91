#pragma once

/// The namespaces of the rooms (ARCHITECTURE.md, "Rooms"). A room uses the names of the rooms that
/// it may include without a prefix. If it declares such a name itself, its own name counts. The
/// names of other rooms are not visible without a prefix. So the compiler, too, reports most uses
/// of a room that another room must not include.
namespace parray {

namespace base {}
namespace math {}
namespace process {
using namespace base;
}
namespace log {
using namespace process;
}
namespace scene {
using namespace base;
using namespace math;
}  // namespace scene
namespace image {
using namespace scene;
}
namespace schedule {
using namespace image;
}
namespace adaptive {
using namespace schedule;
}
namespace trace {
using namespace image;
}

namespace proto {
using namespace schedule;
}

namespace worker {
using namespace log;
using namespace trace;
using namespace proto;
}  // namespace worker

namespace store {
using namespace proto;
}
namespace replica {
using namespace store;
}
namespace coordinator {
using namespace log;
using namespace trace;
using namespace adaptive;
using namespace replica;
}  // namespace coordinator
namespace http {
using namespace coordinator;
}

namespace picture {
using namespace image;
}
namespace input {
using namespace picture;
}
namespace labels {
using namespace input;
}
namespace farm {
using namespace picture;
using namespace coordinator;
using namespace worker;
}  // namespace farm
namespace denoise {
using namespace trace;
using namespace adaptive;
}  // namespace denoise
namespace postprocess {
using namespace labels;
using namespace farm;
}  // namespace postprocess
namespace output {
using namespace postprocess;
using namespace denoise;
}  // namespace output

namespace child_process {
using namespace process;
using namespace proto;
}  // namespace child_process
namespace audit {
using namespace coordinator;
}
namespace compare {
using namespace picture;
}
namespace verify {
using namespace output;
}
namespace plan {
using namespace output;
using namespace audit;
}  // namespace plan
namespace tradeoff {
using namespace plan;
using namespace child_process;
}  // namespace tradeoff
namespace doctor {
using namespace output;
using namespace child_process;
}  // namespace doctor

namespace commands {
using namespace verify;
using namespace compare;
using namespace doctor;
using namespace tradeoff;
}  // namespace commands
namespace scene_sandbox {
using namespace commands;
}
namespace mpi {
using namespace commands;
}
namespace referee {
using namespace worker;
}

}  // namespace parray
