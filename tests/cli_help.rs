//! The command explains itself, and its exit codes say what went wrong.

mod cli;

use cli::{antumbra, stderr, stdout};

#[test]
fn every_command_has_help_with_an_example() {
    let output = antumbra(&["--help"]);
    assert!(output.status.success());
    let help = stdout(&output);
    for command in [
        "demo", "cull", "render", "measure", "sweep", "pipeline", "prepare", "generate", "info",
    ] {
        assert!(help.contains(command), "{command} is not in {help}");
        let output = antumbra(&[command, "--help"]);
        assert!(output.status.success());
        assert!(stdout(&output).contains("Example"), "{command}");
        assert!(
            stdout(&output).contains(&format!("antumbra {command}")),
            "{command}"
        );
    }
    for code in ["0  done", "1  failed", "2  ", "3  --simd"] {
        assert!(help.contains(code), "{code} is not in {help}");
    }
}

#[test]
fn usage_errors_exit_with_2_and_say_so_on_stderr() {
    let wrong: [&[&str]; 12] = [
        &[],
        &["fly"],
        &["render"],
        &["render", "a.glb", "--size", "0x9"],
        &["render", "a.glb", "--size", "big"],
        &["render", "a.glb", "--simd", "mmx"],
        &["render", "a.glb", "--threads", "0"],
        &["render", "a.glb", "--every", "0"],
        &["render", "a.glb", "--budget", "some"],
        &["measure", "a.glb"],
        &[
            "measure",
            "a.glb",
            "--path",
            "p.json",
            "--occluders",
            "best",
        ],
        &["generate", "village", "-o", "v.glb"],
    ];
    for arguments in wrong {
        let output = antumbra(arguments);
        assert_eq!(output.status.code(), Some(2), "{arguments:?}");
        assert!(
            output.stdout.is_empty(),
            "{arguments:?}: {}",
            stdout(&output)
        );
        assert!(!output.stderr.is_empty(), "{arguments:?}");
    }
}

#[test]
fn a_level_that_is_not_there_exits_with_3() {
    // No machine has both of these.
    let missing = if cfg!(target_arch = "aarch64") {
        "avx2"
    } else {
        "neon"
    };
    let commands: [&[&str]; 2] = [
        &["render", "a.glb", "--simd", missing],
        &["measure", "a.glb", "--path", "p.json", "--simd", missing],
    ];
    for arguments in commands {
        let output = antumbra(arguments);
        assert_eq!(
            output.status.code(),
            Some(3),
            "{arguments:?}: {}",
            stderr(&output)
        );
        assert!(
            stderr(&output).starts_with("error: "),
            "{}",
            stderr(&output)
        );
        assert!(stderr(&output).contains(missing), "{}", stderr(&output));
    }
}

#[test]
fn info_names_the_version_the_levels_and_the_threads() {
    let output = antumbra(&["info"]);
    assert!(output.status.success());
    let text = stdout(&output);
    assert!(text.contains(env!("CARGO_PKG_VERSION")), "{text}");
    assert!(text.contains("instruction sets found: scalar"), "{text}");
    assert!(text.contains("instruction set chosen: "), "{text}");
    assert!(text.contains("threads: "), "{text}");
}

#[cfg(unix)]
#[test]
fn a_closed_stdout_is_no_failure() {
    use std::io::pipe;
    use std::process::{Command, Stdio};

    for arguments in [&["info"][..], &["--help"]] {
        let (reader, writer) = pipe().expect("a pipe");
        drop(reader);
        let output = Command::new(cli::EXE)
            .args(arguments)
            .stdout(writer)
            .stderr(Stdio::piped())
            .output()
            .expect("the command starts");
        assert_eq!(output.status.code(), Some(0), "{arguments:?}");
        assert!(!stderr(&output).contains("panicked"), "{}", stderr(&output));
    }
}
