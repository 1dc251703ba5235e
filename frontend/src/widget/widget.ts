/** The notebook widget: the player in a shadow root, its time and pose shared with Python. */

export default { render(): void { /* written below */ } };
