//! Sessions of Zenoh, to the stated endpoints only.

use std::path::Path;
use std::sync::mpsc::{RecvTimeoutError, channel};
use std::time::{Duration, Instant};

use zenoh::{Config, Session, Wait};

/// Default address of a site's router: this host only.
pub const DEFAULT: &str = "tcp/127.0.0.1:7447";

/// How a session reaches its router.
#[derive(Debug, Clone, clap::Args)]
pub struct LinkArgs {
    /// The router
    #[arg(long, value_name = "tcp/HOST:PORT", default_value = DEFAULT)]
    pub connect: String,
    /// Keys and certificates: a configuration file of Zenoh (JSON5)
    #[arg(long, value_name = "FILE")]
    pub zenoh_config: Option<std::path::PathBuf>,
}

/// Opens a session as soon as the router is reachable; afterwards it reconnects by itself. All its publications are below the
/// keys `publishes`. The router then resolves the subscribers once for each of these keys, not once for each publisher. The latter
/// would take time in proportion to the square of their number.
///
/// # Errors
/// The endpoint or the configuration cannot be understood.
pub fn client(link: &LinkArgs, publishes: &[&str]) -> Result<Session, String> {
    let mut config = base(link.zenoh_config.as_deref())?;
    set(&mut config, "mode", "\"client\"")?;
    set(&mut config, "connect/endpoints", &list(&[&link.connect]))?;
    set(&mut config, "connect/timeout_ms", "-1")?;
    set(&mut config, "connect/exit_on_failure", "false")?;
    set(&mut config, "listen/endpoints", "[]")?;
    set(&mut config, "aggregation/publishers", &list(publishes))?;
    open(config, &link.connect)
}

/// Time without an answer after which the router is reported as absent. Attempts go on.
const ABSENT: Duration = Duration::from_secs(10);

/// [`client`], cancelled when `stops` returns true: opening a session waits for the router. A router that does not answer is
/// reported once.
///
/// # Errors
/// As [`client`]; `None` if cancelled.
pub fn client_unless(
    link: &LinkArgs,
    publishes: &[&str],
    stops: impl Fn() -> bool,
) -> Result<Option<Session>, String> {
    let (say, opened) = channel();
    let its = link.clone();
    let publishes: Vec<String> = publishes.iter().map(|&key| key.to_owned()).collect();
    std::thread::spawn(move || {
        let publishes: Vec<&str> = publishes.iter().map(String::as_str).collect();
        // After a cancellation nobody receives it, and the process ends.
        let _ = say.send(client(&its, &publishes));
    });
    let begun = Instant::now();
    let mut is_told = false;
    loop {
        match opened.recv_timeout(Duration::from_millis(50)) {
            Ok(session) => {
                if is_told && session.is_ok() {
                    tracing::info!("the router {} answers", link.connect);
                }
                return session.map(Some);
            }
            Err(RecvTimeoutError::Timeout) if !stops() => {}
            Err(_) => return Ok(None),
        }
        if !is_told && begun.elapsed() > ABSENT {
            is_told = true;
            tracing::warn!(
                "the router {} does not answer, or refuses this certificate; it is asked again until it does",
                link.connect
            );
        }
    }
}

/// Whether a router may listen at this address: without keys on this host only, unless that is stated.
///
/// # Errors
/// It may not.
pub fn is_closed(listen: Option<&str>, is_meant: bool) -> Result<(), String> {
    let Some(listen) = listen.filter(|_| !is_meant) else {
        return Ok(());
    };
    let address = listen.split_once('/').map_or(listen, |(_, rest)| rest);
    let address = address.split(['?', '#']).next().unwrap_or_default();
    let host = address.rsplit_once(':').map_or(address, |(host, _)| host);
    let host = host.trim_start_matches('[').trim_end_matches(']');
    let is_own = host == "localhost"
        || host
            .parse::<std::net::IpAddr>()
            .is_ok_and(|ip| ip.is_loopback());
    if is_own {
        return Ok(());
    }
    Err(crate::error(
        format!("whoever reaches {listen} could write under any machine's name"),
        "--listen",
        "give keys, --zenoh-config FILE (`examples/fleet/keys.sh` makes them), or say --open",
    ))
}

/// Opens a router in this process: the same code as `zenohd`, without its plug-ins.
///
/// # Errors
/// The address is taken, or the configuration cannot be understood.
pub fn router(listen: Option<&str>, file: Option<&Path>) -> Result<Session, String> {
    let mut config = base(file)?;
    set(&mut config, "mode", "\"router\"")?;
    if file.is_none() {
        // Zenoh's default limit of 1000 sessions would leave all further machines without an answer.
        let sessions = crate::MACHINES.to_string();
        set(&mut config, "transport/unicast/max_sessions", &sessions)?;
        set(&mut config, "transport/unicast/accept_pending", "1000")?;
    }
    if let Some(listen) = listen {
        set(&mut config, "listen/endpoints", &list(&[listen]))?;
    }
    open(config, listen.unwrap_or("its configuration"))
}

/// Files that a configuration may name. A session whose file is absent would wait for its router forever, without a word.
const FILES: [&str; 5] = [
    "root_ca_certificate",
    "connect_private_key",
    "connect_certificate",
    "listen_private_key",
    "listen_certificate",
];

/// Whether the files that a configuration names can be read.
fn has_its_files(config: &Config, place: &Path) -> Result<(), String> {
    for key in FILES {
        let named = config.get_json(&format!("transport/link/tls/{key}"));
        let named = named.map(|json| serde_json::from_str::<Option<String>>(&json));
        let Ok(Ok(Some(named))) = named else {
            continue;
        };
        if let Err(e) = std::fs::File::open(&named) {
            return Err(crate::error(
                format!("cannot read the {key} {named}: {e}"),
                place.display(),
                "put the files where the configuration names them, readable by this user; `keys.sh` names those of AT=FOLDER",
            ));
        }
    }
    Ok(())
}

/// A configuration that connects to the stated endpoints only: no multicast, no gossip.
fn base(file: Option<&Path>) -> Result<Config, String> {
    let mut config = match file {
        Some(file) => {
            let config = Config::from_file(file).map_err(|e| {
                crate::error(
                    format!("this is no configuration of Zenoh: {e}"),
                    file.display(),
                    "see `examples/fleet`, which has one that works",
                )
            })?;
            has_its_files(&config, file)?;
            config
        }
        None => Config::default(),
    };
    set(&mut config, "scouting/multicast/enabled", "false")?;
    set(&mut config, "scouting/gossip/enabled", "false")?;
    Ok(config)
}

fn set(config: &mut Config, key: &str, value: &str) -> Result<(), String> {
    config
        .insert_json5(key, value)
        .map_err(|e| refused(&e, value))
}

fn open(config: Config, place: &str) -> Result<Session, String> {
    zenoh::open(config).wait().map_err(|e| refused(&e, place))
}

fn refused(error: &dyn std::fmt::Display, place: &str) -> String {
    let remedy = "name it as tcp/HOST:PORT or tls/HOST:PORT; another program may have the port";
    crate::error(format!("Zenoh refuses this: {error}"), place, remedy)
}

fn list(all: &[&str]) -> String {
    serde_json::to_string(all).unwrap_or_default()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_configuration_without_its_files_is_refused_at_once() {
        let folder = tempfile::tempdir().expect("a folder");
        let (file, key) = (
            folder.path().join("ex-1.json5"),
            folder.path().join("ca.pem"),
        );
        let text = format!(
            "{{ transport: {{ link: {{ tls: {{ root_ca_certificate: {:?} }} }} }} }}",
            key.display().to_string()
        );
        std::fs::write(&file, text).expect("written");
        let said = base(Some(&file)).expect_err("there is no such file");
        assert!(
            said.contains("root_ca_certificate") && said.contains("ex-1.json5"),
            "{said}"
        );
        std::fs::write(&key, "").expect("written");
        assert!(base(Some(&file)).is_ok(), "what is in it, Zenoh says");
    }

    #[test]
    fn a_router_for_others_needs_keys_or_the_word() {
        for own in [
            "tcp/127.0.0.1:7447",
            "tcp/localhost:1",
            "tls/[::1]:7447",
            "tcp/127.8.0.1:0",
        ] {
            assert!(is_closed(Some(own), false).is_ok(), "{own}");
        }
        for other in [
            "tcp/0.0.0.0:7447",
            "tcp/[::]:7447",
            "udp/10.0.0.1:1",
            "tcp/site.example:7447",
            "tcp/0.0.0.0:1#iface=lo",
        ] {
            assert!(is_closed(Some(other), false).is_err(), "{other}");
            assert!(is_closed(Some(other), true).is_ok(), "{other}");
        }
        assert!(is_closed(None, false).is_ok());
    }
}
