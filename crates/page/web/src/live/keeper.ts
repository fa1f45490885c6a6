// Keeping the text: as a file to download, or, served by `bksim edit`, in its own file.

import { download } from './files';

/** How often the file is looked at, ms. */
const EVERY = 1000;

export class Keeper {
  /** The text as it is in the file. */
  private kept = '';
  private isStopped = false;

  constructor(
    private readonly isServed: boolean,
    private readonly name: string,
    private readonly text: () => string,
    private readonly take: (text: string) => void,
    private readonly say: (words: string) => void,
  ) {}

  begin(text: string): void {
    this.kept = text;
    if (this.isServed) window.setTimeout(() => void this.look(), EVERY);
    this.changed();
  }

  /** Marks the title while there is something that is not kept. */
  changed(): void {
    document.title = this.text() === this.kept ? this.name : `● ${this.name}`;
  }

  async save(): Promise<void> {
    const text = this.text();
    if (!this.isServed) {
      download(`${this.name}.toml`, new Blob([text], { type: 'application/toml' }));
      this.kept = text;
      this.changed();
      return;
    }
    const answer = await fetch('file', {
      method: 'PUT',
      headers: { 'Content-Type': 'application/json' },
      body: JSON.stringify({ before: this.kept, text }),
    });
    if (answer.ok) {
      this.kept = text;
      this.say('Saved.');
    } else {
      this.say(await answer.text());
    }
    this.changed();
  }

  /** Takes what another program has written into the file, unless there are changes here. */
  private async look(): Promise<void> {
    try {
      const answer = await fetch('file');
      if (answer.ok) {
        const text = await answer.text();
        if (text !== this.kept) {
          const isClean = this.text() === this.kept;
          if (isClean) {
            this.kept = text;
            this.take(text);
            this.say('The file was changed by another program, and is read again.');
          } else if (text === this.text()) {
            this.kept = text;
          } else {
            this.say('The file was changed by another program; undo the changes here to take it.');
          }
        }
        this.isStopped = false;
      }
    } catch {
      if (!this.isStopped) this.say('`bksim edit` has ended: download the text to keep it.');
      this.isStopped = true;
    }
    window.setTimeout(() => void this.look(), this.isStopped ? 5 * EVERY : EVERY);
  }
}
