// Search runs in a worker. Browsers refuse workers to a page that is opened as a file: there it runs in a hidden frame.
if (location.protocol === "file:") {
  window.Worker = class extends EventTarget {
    constructor(address) {
      super();
      this.unsent = [];
      const frame = document.createElement("iframe");
      frame.hidden = true;
      document.body.append(frame);
      this.inside = frame.contentWindow;
      const script = frame.contentDocument.createElement("script");
      script.src = new URL(address, location.href).href;
      script.addEventListener("load", () => {
        this.inside.postMessage = (data) => {
          const message = new MessageEvent("message", { data });
          this.dispatchEvent(message);
          this.onmessage?.(message);
        };
        const unsent = this.unsent;
        this.unsent = null;
        unsent.forEach((data) => this.postMessage(data));
      });
      frame.contentDocument.head.append(script);
    }

    postMessage(data) {
      if (this.unsent) this.unsent.push(data);
      else setTimeout(() => this.inside.onmessage({ data }));
    }

    terminate() {
      this.inside.frameElement.remove();
    }
  };
}
