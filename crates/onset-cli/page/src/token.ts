// Token that identifies the user to the program. The fragment (after #) of the address printed by `onset explore` contains it. It is removed
// from the address immediately, so that no link contains it; the browser stores it for the pages of this server.

const KEPT = "onset-token";
/** Request header with the token. */
export const SHOWN = "Onset-Token";

let own = "";

/** Token, or an empty string. */
export const token = (): string => own;

/** Removes the token from the address and returns it. */
function taken(): string | null {
  const parts = location.hash.replace(/^#/, "").split("&");
  const found = parts.find((part) => part.startsWith("token="));
  if (found === undefined) return null;
  const rest = parts.filter((part) => part !== found).join("&");
  history.replaceState(history.state, "", rest === "" ? location.pathname : `#${rest}`);
  return found.slice("token=".length);
}

/** Token stored by this browser for an earlier page. */
function kept(): string {
  try {
    return localStorage.getItem(KEPT) ?? "";
  } catch {
    // The browser may forbid storage.
    return "";
  }
}

/** Exchanges the token of the address, which may be valid only once, for a stored one; without it the stored token is used. */
export async function enter(): Promise<void> {
  const shown = taken();
  if (shown === null) {
    if (own === "") own = kept();
    return;
  }
  const answer = await fetch("api/enter", { method: "POST", headers: { [SHOWN]: shown } });
  const given = (await answer.json()) as { token?: string };
  // A link with a token of another run is treated as a link without one.
  own = given.token ?? (own === "" ? kept() : own);
  if (given.token === undefined) return;
  try {
    localStorage.setItem(KEPT, own);
  } catch {
    // Without storage the token is required again next time.
  }
}
