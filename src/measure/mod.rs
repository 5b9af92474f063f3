//! Is the culling right, how much does it find, and what does it cost?
//!
//! Every frame of a camera path is culled and timed, and judged against an exact [`Reference`]: the object-id picture
//! of the whole scene at final size. Two yardsticks, the ideal box test and the ideal face test (`ideal`), say how
//! many of the hidden objects a perfect test of bounding boxes would have found. A third, the [`Oracle`], says how few
//! triangles would have done. `throughput` compares frames one by one with frames in a pipeline.

mod animation;
mod ideal;
mod oracle;
mod pareto;
mod reference;
mod report;
mod run;
mod schedule;
mod sweep;
mod throughput;

pub use animation::{Animation, Moving};
pub use ideal::{ExactDepths, ideal_box_test, ideal_face_test};
pub use oracle::{Oracle, Owner, within};
pub use pareto::pareto_front;
pub use reference::Reference;
pub use report::{FrameReport, Report, SceneReport, SettingsReport, TimesUs, Totals};
pub use run::{MeasureSettings, run};
pub use schedule::{Prediction, SIMULATED_THREADS, Simulated, Simulation, makespan};
pub use sweep::{
    LEAST_HIDDEN, MeasuredThreads, ORACLE, PathFrame, PointFrame, Scaling, Sweep, SweepPoint,
    SweepSettings, SweptWith, sweep,
};
pub use throughput::{
    FinalDraw, Flow, FlowReport, LeastAndMedian, ThroughputError, ThroughputSettings, throughput,
};
