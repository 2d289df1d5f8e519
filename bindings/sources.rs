// For build scripts: the sources to which a saved state belongs.

/// A checksum of all sources below these folders; cargo runs the script again when one changes.
fn sum_of_sources(folders: &[&str]) -> u64 {
    let mut files = Vec::new();
    for folder in folders {
        println!("cargo:rerun-if-changed={folder}");
        sources(std::path::Path::new(folder), &mut files);
    }
    files.sort();
    let contents = files.iter().map(|file| std::fs::read(file).unwrap_or_default());
    contents.fold(0xcbf2_9ce4_8422_2325, |sum, content| add(sum, &content))
}

/// FNV-1a.
fn add(sum: u64, bytes: &[u8]) -> u64 {
    bytes.iter().fold(sum, |sum, byte| {
        (sum ^ u64::from(*byte)).wrapping_mul(0x0100_0000_01b3)
    })
}

fn sources(folder: &std::path::Path, files: &mut Vec<std::path::PathBuf>) {
    for entry in std::fs::read_dir(folder).into_iter().flatten().flatten() {
        let path = entry.path();
        if path.is_dir() {
            sources(&path, files);
        } else if path.extension().is_some_and(|e| e == "rs") {
            files.push(path);
        }
    }
}
