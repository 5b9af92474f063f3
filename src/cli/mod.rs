//! The command line: what is asked for, and how it ends.
//!
//! Results go to stdout; errors, warnings and progress go to stderr, progress only if a person is watching. A reader
//! that closes stdout early ends nothing: the files that were asked for are still written.

mod cull;
mod demo;
mod demo_report;
mod depth_options;
mod failure;
mod final_pass;
mod generate;
mod info;
mod measure;
mod options;
mod output;
mod outside;
mod pipeline;
mod prepare;
mod progress;
mod render;
mod sweep;
mod visibility_grid;

use std::process::ExitCode;

use clap::{Parser, Subcommand};

const EXIT_CODES: &str = "\
Exit codes:
  0  done
  1  failed: the scene or path is damaged, a file cannot be written, a check did not hold
  2  the command line makes no sense
  3  --simd or --final-pass names what this machine or build lacks";

const EXAMPLES: &str = "\
Examples:
  antumbra demo
  antumbra cull castle.glb --path castle.path.json
  antumbra render castle.glb --overlay --out pictures
  antumbra measure castle.glb --path castle.path.json
  antumbra sweep castle.glb --path castle.walk.json --every 8
  antumbra pipeline castle.glb --path castle.walk.json
  antumbra prepare castle.glb -o castle.antumbra
  antumbra generate city -o city.glb";

/// Occlusion culling on the CPU: which objects of a scene can a camera see?
#[derive(Debug, Parser)]
#[command(name = "antumbra", version, max_term_width = 100)]
#[command(after_help = format!("{EXAMPLES}\n\n{EXIT_CODES}"))]
struct Cli {
    #[command(subcommand)]
    command: Command,
}

#[derive(Debug, Subcommand)]
enum Command {
    Demo(demo::Demo),
    Cull(cull::Cull),
    Render(render::Render),
    Measure(measure::Measure),
    Sweep(sweep::Sweep),
    Pipeline(pipeline::Pipeline),
    Prepare(prepare::Prepare),
    Generate(generate::Generate),
    Info(info::Info),
}

/// Runs the command that the process was started with.
pub fn run() -> ExitCode {
    let done = match Cli::parse().command {
        Command::Demo(demo) => demo.run(),
        Command::Cull(cull) => cull.run(),
        Command::Render(render) => render.run(),
        Command::Measure(measure) => measure.run(),
        Command::Sweep(sweep) => sweep.run(),
        Command::Pipeline(pipeline) => pipeline.run(),
        Command::Prepare(prepare) => prepare.run(),
        Command::Generate(generate) => generate.run(),
        Command::Info(info) => info.run(),
    };
    match done {
        Ok(()) => ExitCode::SUCCESS,
        Err(failure) => {
            output::complain("error", &failure);
            failure.exit_code()
        }
    }
}
