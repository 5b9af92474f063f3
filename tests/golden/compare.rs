//! Holds a picture against the one that is kept in `tests/golden/`.
//!
//! `ANTUMBRA_BLESS=1 cargo test --release --test golden` keeps what is drawn now. Look at every picture that it changes.

use std::io::BufWriter;
use std::path::{Path, PathBuf};

use antumbra::final_pass::Image;
use image::codecs::png::{CompressionType, FilterType, PngEncoder};
use image::{ExtendedColorType, ImageEncoder};

/// Fails if a picture differs from the kept one in one byte, and leaves both, and where they differ, to be looked at.
#[track_caller]
pub fn assert_golden(name: &str, drawn: &Image) {
    let kept = Path::new(env!("CARGO_MANIFEST_DIR")).join(format!("tests/golden/{name}.png"));
    if std::env::var_os("ANTUMBRA_BLESS").is_some_and(|bless| bless == "1") {
        return write(drawn, &kept);
    }
    let expected = read(&kept);
    if expected.as_ref() == Ok(drawn) {
        return;
    }
    let left = |what: &str, picture: &Image| -> PathBuf {
        let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("golden");
        std::fs::create_dir_all(&folder).expect("a folder can be made");
        let file = folder.join(format!("{name}.{what}.png"));
        write(picture, &file);
        file
    };
    let actual = left("drawn", drawn);
    let difference = match &expected {
        Err(cause) => cause.clone(),
        Ok(expected) if size(expected) != size(drawn) => {
            format!("{:?} pixels, not {:?}", size(drawn), size(expected))
        }
        Ok(expected) => format!(
            "{} pixels differ, in red in {}",
            drawn.differing_pixels(expected),
            left("difference", &drawn.difference(expected)).display()
        ),
    };
    let expected = expected.map_or(kept, |expected| left("expected", &expected));
    panic!(
        "the picture {name} is not the one that is kept: {difference}\n  expected: {}\n  drawn:    {}\n\
         If the drawn one is right, keep it: ANTUMBRA_BLESS=1 cargo test --release --test golden",
        expected.display(),
        actual.display()
    );
}

fn size(picture: &Image) -> [usize; 2] {
    [picture.width(), picture.height()]
}

fn read(file: &Path) -> Result<Image, String> {
    let rgb = image::open(file)
        .map_err(|e| format!("{}: {e}", file.display()))?
        .to_rgb8();
    let mut picture = Image::filled(rgb.width() as usize, rgb.height() as usize, [0; 3]);
    for (to, from) in picture.pixels_mut().iter_mut().zip(rgb.pixels()) {
        *to = from.0;
    }
    Ok(picture)
}

/// Writes a PNG as small as it gets: these are kept with the source.
fn write(picture: &Image, file: &Path) {
    let out = std::fs::File::create(file).expect("the file can be written");
    PngEncoder::new_with_quality(
        BufWriter::new(out),
        CompressionType::Best,
        FilterType::Adaptive,
    )
    .write_image(
        picture.pixels().as_flattened(),
        picture.width() as u32,
        picture.height() as u32,
        ExtendedColorType::Rgb8,
    )
    .expect("a picture");
}
