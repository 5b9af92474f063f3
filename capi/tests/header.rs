//! The header that is committed is the one that cbindgen makes of the sources.

use std::path::Path;

/// In the order of the header.
const SOURCES: [&str; 16] = [
    "version",
    "status",
    "level",
    "camera",
    "camera_path",
    "material",
    "questions",
    "scene",
    "builder",
    "settings",
    "statistics",
    "culler",
    "culler_clusters",
    "culler_memory",
    "occluder",
    "occlusion_buffer",
];

#[test]
fn the_header_is_that_of_the_sources() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR"));
    let config = cbindgen::Config::from_file(folder.join("cbindgen.toml")).expect("settings");
    let builder = cbindgen::Builder::new().with_config(config);
    let builder = SOURCES.iter().fold(builder, |builder, source| {
        builder.with_src(folder.join("src").join(source).with_extension("rs"))
    });
    let mut made = Vec::new();
    builder
        .generate()
        .expect("the sources are understood")
        .write(&mut made);
    let made = String::from_utf8(made).expect("UTF-8");
    let file = folder.join("include/antumbra.h");
    if std::env::var_os("ANTUMBRA_WRITE_HEADER").is_some() {
        std::fs::write(&file, &made).expect("the header is written");
    }
    let committed = std::fs::read_to_string(&file).expect("the header is there");
    assert!(
        made == committed,
        "include/antumbra.h is not that of the sources: set ANTUMBRA_WRITE_HEADER=1 and run this test again"
    );
}
