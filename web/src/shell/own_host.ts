/** Whether a host name means the computer on which it is opened, so that a link with it leads nobody else here. */
export const isOwnHost = (hostname: string): boolean =>
  /^(localhost|.+\.localhost|127(\.\d+){3}|\[::1\])$/.test(hostname);
