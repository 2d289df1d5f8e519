//! Nothing: the build scripts of `iceoryx2-pal-posix` and `iceoryx2-pal-os-api` call bindgen on QNX alone.
