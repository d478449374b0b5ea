import { answer } from './instance.js';

let part;
self.onmessage = ({ data }) => {
    let said;
    [part, said] = answer(part, data);
    self.postMessage(said);
};
