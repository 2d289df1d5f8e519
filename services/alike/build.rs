//! Nothing: what is compiled before a build script is compiled with the features of both workspaces, like the rest.

fn main() {
    println!("cargo::rerun-if-changed=build.rs");
}
