//! What a browser may ask for, and who may ask.
//!
//! A page in the user's browser may send requests to any port of this machine, and a name may be bound to its address. So a request needs
//! a secret, from the printed link or the cookie that the link's page sets; its `Host` must be this machine's; and it may only read.

use std::net::SocketAddr;

/// Bytes of a request's head.
pub(crate) const HEAD: usize = 8192;
/// Bytes of a body.
pub(crate) const BODY: usize = 8192;
/// Headers of a request, and bytes of its target.
const HEADERS: usize = 64;
const TARGET: usize = 512;

/// A request that may be answered.
#[derive(Debug, PartialEq, Eq)]
pub(crate) struct Request {
    /// Path without the question mark and what comes after it.
    pub(crate) path: String,
    /// The generation that it asks for.
    pub(crate) generation: Option<u32>,
    /// The room that a picture has, in pixels.
    pub(crate) width: Option<u32>,
    /// Whether only the head of the answer is wanted.
    pub(crate) is_head: bool,
    /// A wish to change something: the length of its body, and its secret.
    pub(crate) wish: Option<(usize, String)>,
    /// Whether the secret came with the link, so that a cookie has to be set.
    pub(crate) is_link: bool,
}

/// Why a request isn't answered: the status and what it says.
pub(crate) type Refusal = (u16, &'static str);

/// Who may ask, and where.
#[derive(Debug)]
pub(crate) struct Door {
    pub(crate) address: SocketAddr,
    /// 32 hexadecimal digits.
    pub(crate) secret: String,
    /// Whether the page may change something.
    pub(crate) may_edit: bool,
}

impl Door {
    /// The cookie's name: browsers send cookies to all ports of a machine.
    pub(crate) fn cookie(&self) -> String {
        format!("oneiro-{}", self.address.port())
    }

    /// Reads the head of a request.
    ///
    /// # Errors
    /// What is wrong, as a status.
    pub(crate) fn read(&self, head: &[u8]) -> Result<Request, Refusal> {
        let mut headers = [httparse::EMPTY_HEADER; HEADERS];
        let mut parsed = httparse::Request::new(&mut headers);
        match parsed.parse(head) {
            Ok(httparse::Status::Complete(_)) => {}
            _ => return Err((400, "not a request")),
        }
        let (Some(method), Some(target)) = (parsed.method, parsed.path) else {
            return Err((400, "not a request"));
        };
        let header = |name: &str| {
            let mut own = parsed
                .headers
                .iter()
                .filter(|header| header.name.eq_ignore_ascii_case(name));
            let first = own
                .next()
                .map(|header| std::str::from_utf8(header.value).unwrap_or("\u{fffd}"));
            (first, own.next().is_some())
        };
        match header("host") {
            (Some(host), false) if is_here(host, self.address.port()) => {}
            _ => return Err((403, "another host: open the address that oneiro watch has printed")),
        }
        let allowed: &[&str] = if self.may_edit {
            &["GET", "HEAD", "POST"]
        } else {
            &["GET", "HEAD"]
        };
        if !allowed.contains(&method) {
            return Err((405, "a method that is not allowed"));
        }
        // A request from another site, in browsers that say so.
        if let (Some(site), _) = header("sec-fetch-site")
            && !["same-origin", "none"].contains(&site)
        {
            return Err((403, "from another site"));
        }
        if target.len() > TARGET || !target.starts_with('/') || !target.bytes().all(|byte| byte.is_ascii_graphic()) {
            return Err((400, "not an address of this page"));
        }
        let (path, query) = target.split_once('?').unwrap_or((target, ""));
        let value = |name: &str| {
            let mut pairs = query.split('&').filter_map(|pair| pair.split_once('='));
            pairs.find(|(own, _)| *own == name).map(|(_, value)| value)
        };
        let is_link = path == "/" && value("token").is_some_and(|own| is_secret(&self.secret, own));
        let name = self.cookie();
        let cookies = header("cookie").0.unwrap_or_default().split(';');
        let mut cookies = cookies.filter_map(|cookie| cookie.trim().split_once('='));
        if !is_link && !cookies.any(|(own, value)| own == name && is_secret(&self.secret, value)) {
            return Err((403, "no token: open the address that oneiro watch has printed"));
        }
        let wish = match method {
            "POST" => Some(wish(|name| header(name).0, self.address.port())?),
            _ => None,
        };
        let number = |name: &str| {
            value(name)
                .map(str::parse)
                .transpose()
                .map_err(|_| (400, "not a whole number"))
        };
        Ok(Request {
            path: path.to_owned(),
            generation: number("generation")?,
            width: number("width")?,
            is_head: method == "HEAD",
            wish,
            is_link,
        })
    }
}

/// Whether a host is this machine, with the port.
fn is_here(host: &str, port: u16) -> bool {
    ["localhost", "127.0.0.1", "[::1]"]
        .iter()
        .any(|name| host == format!("{name}:{port}"))
}

/// Compares all digits, whichever differ: the time tells nothing.
pub(crate) fn is_secret(secret: &str, text: &str) -> bool {
    let differs = secret.bytes().zip(text.bytes()).fold(0, |all, (a, b)| all | (a ^ b));
    text.len() == secret.len() && differs == 0
}

/// The length of a wish's body and its secret, in a header that no other site's page can send.
fn wish<'a>(header: impl Fn(&str) -> Option<&'a str>, port: u16) -> Result<(usize, String), Refusal> {
    let host = header("origin").and_then(|origin| origin.strip_prefix("http://"));
    if !host.is_some_and(|host| is_here(host, port)) {
        return Err((403, "from another site"));
    }
    if header("content-type") != Some("application/json") || header("transfer-encoding").is_some() {
        return Err((400, "not JSON of a known length"));
    }
    let length = header("content-length").and_then(|length| length.parse().ok());
    let length = length
        .filter(|length| *length <= BODY)
        .ok_or((400, "too long, or of unknown length"))?;
    Ok((length, header("x-oneiro-edit").unwrap_or_default().to_owned()))
}

#[cfg(test)]
mod tests {
    use super::*;

    const SECRET: &str = "0123456789abcdef0123456789abcdef";

    fn door() -> Door {
        Door {
            address: ([127, 0, 0, 1], 8080).into(),
            secret: SECRET.to_owned(),
            may_edit: false,
        }
    }

    fn status(head: &str) -> u16 {
        door().read(head.as_bytes()).map_or_else(|(status, _)| status, |_| 200)
    }

    #[test]
    fn the_link_and_then_the_cookie_open_the_door() {
        let link = format!("GET /?token={SECRET} HTTP/1.1\r\nHost: localhost:8080\r\n\r\n");
        assert!(door().read(link.as_bytes()).unwrap().is_link);
        let cookie = format!("Cookie: a=b; oneiro-8080={SECRET}");
        let later =
            format!("HEAD /scene/12?generation=7&width=640 HTTP/1.1\r\nHost: 127.0.0.1:8080\r\n{cookie}\r\n\r\n");
        let read = door().read(later.as_bytes()).unwrap();
        let wanted = Request {
            path: "/scene/12".into(),
            generation: Some(7),
            width: Some(640),
            is_head: true,
            wish: None,
            is_link: false,
        };
        assert_eq!(read, wanted);
    }

    /// Each refusal alone: everything else is as it should be.
    #[test]
    fn everything_else_is_refused() {
        let cookie = format!("Cookie: oneiro-8080={SECRET}\r\n");
        let with = |line: &str, host: &str, more: &str| status(&format!("{line} HTTP/1.1\r\n{host}{cookie}{more}\r\n"));
        let host = "Host: localhost:8080\r\n";
        assert_eq!(with("GET /events", host, ""), 200);
        for method in ["POST", "PUT", "DELETE", "OPTIONS", "PATCH", "TRACE", "get"] {
            assert_eq!(with(&format!("{method} /events"), host, ""), 405, "{method}");
        }
        for other in [
            "",
            "Host: evil.example\r\n",
            "Host: localhost\r\n",
            "Host: localhost:81\r\n",
            "Host: localhost:8080\r\nHost: localhost:8080\r\n",
        ] {
            assert_eq!(with("GET /events", other, ""), 403, "{other}");
        }
        for site in ["cross-site", "same-site"] {
            assert_eq!(
                with("GET /events", host, &format!("Sec-Fetch-Site: {site}\r\n")),
                403,
                "{site}"
            );
        }
        for target in [
            "events",
            "http://localhost:8080/events",
            &format!("/{}", "a".repeat(TARGET)),
        ] {
            assert_eq!(with(&format!("GET {target}"), host, ""), 400, "{target}");
        }
        assert_eq!(with("GET /scene/1?generation=-1", host, ""), 400);
        let plain = |more: &str, target: &str| status(&format!("GET {target} HTTP/1.1\r\n{host}{more}\r\n"));
        assert_eq!(plain("", "/events"), 403);
        assert_eq!(
            plain("", &format!("/events?token={SECRET}")),
            403,
            "the secret is for the first page alone"
        );
        assert_eq!(plain("", "/?token=0123"), 403);
        assert_eq!(plain(&format!("Cookie: oneiro-8081={SECRET}\r\n"), "/events"), 403);
        assert_eq!(status("GET / HTTP/1.1\r\n"), 400, "it has not ended");
        assert_eq!(status("\u{0}\r\n\r\n"), 400);
    }

    /// A wish needs the page's origin, JSON, a length and, checked later, the editor's secret.
    #[test]
    fn only_the_page_itself_may_wish() {
        let door = Door {
            may_edit: true,
            ..door()
        };
        let post = |more: &str| {
            let head =
                format!("POST /evolve HTTP/1.1\r\nHost: localhost:8080\r\nCookie: oneiro-8080={SECRET}\r\n{more}\r\n");
            door.read(head.as_bytes()).map(|request| request.wish)
        };
        let (origin, json) = (
            "Origin: http://localhost:8080\r\n",
            "Content-Type: application/json\r\n",
        );
        let whole = format!("{origin}{json}Content-Length: 12\r\nX-Oneiro-Edit: abc\r\n");
        assert_eq!(post(&whole), Ok(Some((12, "abc".into()))));
        let status = |more: &str| post(more).unwrap_err().0;
        assert_eq!(status(&whole.replace("localhost:8080", "evil.example")), 403);
        assert_eq!(status(&whole.replace(origin, "")), 403);
        assert_eq!(status(&whole.replace("application/json", "text/plain")), 400);
        assert_eq!(status(&whole.replace("12", "12345678")), 400);
        assert_eq!(status(&format!("{whole}Transfer-Encoding: chunked\r\n")), 400);
    }
}
