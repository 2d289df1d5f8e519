//! The address of a page, as users write it.

use std::net::SocketAddr;

/// An address with its port, or one of both, completed by the `default`. A port alone and `localhost` mean its host.
///
/// # Errors
/// It is neither; the error says how to write it.
pub fn address(text: &str, default: &str) -> Result<SocketAddr, String> {
    let default: SocketAddr = default.parse().map_err(|_| "no default")?;
    let port = ["", ":", "localhost:"]
        .into_iter()
        .find_map(|before| text.strip_prefix(before)?.parse().ok());
    let of_port = port.map(|port| SocketAddr::new(default.ip(), port));
    let host = || {
        text.parse()
            .map(|host| SocketAddr::new(host, default.port()))
    };
    let found = text.parse().ok().or(of_port).or_else(|| host().ok());
    let found = found.or_else(|| (text == "localhost").then_some(default));
    found.ok_or_else(|| format!("write it like {default}, or a port alone"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_address_may_be_a_port_or_a_host() {
        let address = |text| address(text, "127.0.0.1:8440");
        for (text, meant) in [
            ("127.0.0.1:8441", "127.0.0.1:8441"),
            ("[::1]:8441", "[::1]:8441"),
            ("8441", "127.0.0.1:8441"),
            (":8441", "127.0.0.1:8441"),
            ("localhost:8441", "127.0.0.1:8441"),
            ("localhost", "127.0.0.1:8440"),
            ("0.0.0.0", "0.0.0.0:8440"),
            ("::1", "[::1]:8440"),
        ] {
            let said = address(text).map(|address| address.to_string());
            assert_eq!(said, Ok(meant.to_owned()), "{text}");
        }
        for text in ["", "8440x", "127.0.0.1:99999", "http://localhost:8440"] {
            assert!(
                address(text).is_err_and(|e| e.contains("127.0.0.1:8440")),
                "{text}"
            );
        }
    }
}
