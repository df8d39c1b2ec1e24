//! Files and streams without end, and bytes that are no text.

use std::path::PathBuf;

use modyn_read::internals::{MAX_BYTES, not_text, read_at_most};
use modyn_read::read::file::{read_first, read_text};
use modyn_read::{FileStore, ReadOptions, read_file};

fn refused(places: &[&str]) -> String {
    let places: Vec<PathBuf> = places.iter().map(PathBuf::from).collect();
    read_first("a.urdf", &places).expect_err("nothing to read").to_string()
}

#[test]
fn a_missing_file_is_looked_for_in_each_place_once() {
    let root = env!("CARGO_MANIFEST_DIR");
    let message = refused(&["src/a.urdf", &format!("{root}/src/a.urdf"), "/no/a.urdf"]);
    assert!(message.contains("tried `src/a.urdf`, `/no/a.urdf`\n"), "{message}");
}

#[test]
fn a_folder_is_no_file() {
    assert!(refused(&["no/such", "src"]).contains("`src` cannot be read: it is not a file"));
}

#[test]
fn a_file_without_end_is_not_read() {
    let path = std::env::temp_dir().join(format!("modyn-{}.urdf", std::process::id()));
    // A sparse file takes no space.
    let file = std::fs::File::create(&path).expect("a file");
    file.set_len(MAX_BYTES as u64 + 1).expect("a hole");
    let message = refused(&[&path.to_string_lossy()]);
    let _ = std::fs::remove_file(&path);
    assert!(
        message.contains("error[excessive]") && message.contains("more than 1073741824"),
        "{message}"
    );
}

/// Standard input may have no end: at most the size of a description is read.
#[test]
fn a_stream_without_end_is_not_read() {
    let found = read_at_most(1000, "standard input", std::io::repeat(b' ')).expect_err("endless");
    let message = found.to_string();
    assert!(
        message.starts_with("error[excessive]: standard input has more than 1000 bytes"),
        "{message}"
    );
    assert_eq!(read_at_most(3, "x", &b"abc"[..]).expect("fits"), "abc");
    let found = read_text("standard input", &b"<robot>\n\xff"[..]).expect_err("no text");
    assert!(found.to_string().starts_with("standard input:2:1: error[not-text]"), "{found}");
}

#[test]
fn bytes_that_are_no_text_have_a_place() {
    let error = String::from_utf8(b"<robot>\n\xc3\xa9\xff".to_vec()).expect_err("0xff");
    assert_eq!(
        not_text("a.urdf", &error).to_string().lines().next(),
        Some("a.urdf:2:2: error[not-text]: this is not UTF-8 text: byte 0xff")
    );
    let usd = String::from_utf8(b"PXR-USDC\0\xff".to_vec()).expect_err("0xff");
    let shown = not_text("a.usd", &usd).to_string();
    assert!(shown.contains("usd_to_urdf robot.usd"), "{shown}");
}

/// MuJoCo saves archives, whose bytes can be ASCII.
#[test]
fn an_archive_is_to_be_unpacked() {
    let found =
        read_text("arm.mjz", &b"PK\x03\x04 arm.xml"[..]).expect_err("an archive").to_string();
    assert!(found.contains("error[not-text]: this is a zip archive"), "{found}");
    assert!(found.contains("`unzip FILE -d FOLDER`"), "{found}");
}

#[test]
fn a_missing_description_is_named_with_the_place_of_relative_paths() {
    let errors = read_file("no/such.urdf", &ReadOptions::default()).expect_err("missing");
    let message = errors.to_string();
    assert!(message.starts_with("error[missing-file]: `no/such.urdf` does not exist"), "{message}");
    assert!(message.contains("from the current folder"), "{message}");
}

#[test]
fn a_description_in_memory_is_read_with_the_files_that_it_names() {
    let main = r#"<mujoco><include file="arm.xml"/></mujoco>"#;
    let arm = r#"<mujoco><worldbody><body name="arm"><joint/><geom size="1"/></body></worldbody></mujoco>"#;
    let files = [("robots/robot.xml", main), ("robots/arm.xml", arm)];
    let files = files.map(|(path, text)| (path.into(), text.as_bytes().to_vec()));
    let options = ReadOptions { files: FileStore::in_memory(files), ..Default::default() };
    let reading = read_file("robots/robot.xml", &options).expect("a robot");
    assert_eq!(reading.model.nv(), 1);
    assert_eq!(reading.files, [std::path::Path::new("robots/arm.xml")]);
}
