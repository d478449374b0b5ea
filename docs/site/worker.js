// Browsers start no worker for a page that was opened from a file, and the search is one: there it runs in a hidden frame.
if (location.protocol === "file:") {
    window.Worker = class {
        constructor(url) {
            this.frame = document.createElement("iframe");
            this.frame.hidden = true;
            document.body.append(this.frame);
            const inside = this.frame.contentWindow;
            inside.postMessage = (data) => setTimeout(() => this.onmessage && this.onmessage({ data }));
            const script = inside.document.createElement("script");
            script.src = url;
            this.begun = new Promise((resolve) => (script.onload = resolve));
            inside.document.body.append(script);
        }
        postMessage(data) {
            this.begun.then(() => {
                const inside = this.frame.contentWindow;
                inside.dispatchEvent(new inside.MessageEvent("message", { data }));
            });
        }
        terminate() {
            this.frame.remove();
        }
    };
}
