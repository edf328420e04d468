//! Is there a display that a window could open on?

/// Why no window can open here, or `None` if one can.
#[cfg(not(target_os = "linux"))]
pub fn missing() -> Option<String> {
    None
}

/// Why no window can open here, or `None` if one can.
///
/// The examples are built for X11, which every Wayland desktop offers as well.
#[cfg(target_os = "linux")]
pub fn missing() -> Option<String> {
    let variable = |name| std::env::var(name).ok().filter(|value| !value.is_empty());
    match (variable("DISPLAY"), variable("WAYLAND_DISPLAY")) {
        (Some(display), _) if answers(&display) => None,
        (Some(display), _) => Some(format!("no X server answers at DISPLAY={display}")),
        (None, Some(_)) => Some("the examples open windows through X11, and DISPLAY is not set".into()),
        (None, None) => Some("there is no display (neither DISPLAY nor WAYLAND_DISPLAY is set)".into()),
    }
}

/// Knocks at a local X server; one on another host is taken at its word.
#[cfg(target_os = "linux")]
fn answers(display: &str) -> bool {
    use std::os::linux::net::SocketAddrExt;
    use std::os::unix::net::{SocketAddr, UnixStream};

    let Some(screen) = display.strip_prefix("unix").unwrap_or(display).strip_prefix(':') else {
        return true;
    };
    let number = screen.split('.').next().unwrap_or(screen);
    let path = format!("/tmp/.X11-unix/X{number}");
    let in_abstract_namespace = || {
        let address = SocketAddr::from_abstract_name(&path)?;
        UnixStream::connect_addr(&address)
    };
    UnixStream::connect(&path).is_ok() || in_abstract_namespace().is_ok()
}
