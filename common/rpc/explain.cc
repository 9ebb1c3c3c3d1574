// ExplainRpcSecurity: a TLS handshake by hand, because gRPC keeps the reason of a failed one to
// itself.
#include <netdb.h>
#include <openssl/err.h>
#include <openssl/ssl.h>
#include <openssl/x509_vfy.h>
#include <openssl/x509v3.h>
#include <sys/socket.h>
#include <sys/time.h>
#include <unistd.h>

#include "common/base/status.h"
#include "common/rpc/endpoint.h"
#include "common/rpc/free_with.h"

namespace parallax {
namespace {

constexpr int kPatience_s = 3;
constexpr char kHowToIssue[] =
    "a certificate that the farm's operator made with `coordinator init DIR --issue ROLE NAME`";

// Returns a connected socket; -1 if the address can't be reached, which is no fault of security.
int Connect(const RpcAddress& address) {
  addrinfo hints{};
  hints.ai_socktype = SOCK_STREAM;
  addrinfo* found = nullptr;
  if (getaddrinfo(address.host.c_str(), std::to_string(address.port).c_str(), &hints, &found) !=
      0) {
    return -1;
  }
  int connected = -1;
  for (const addrinfo* at = found; at != nullptr && connected < 0; at = at->ai_next) {
    const int fd = socket(at->ai_family, SOCK_STREAM | SOCK_CLOEXEC, 0);
    if (fd < 0) continue;
    const timeval patience{kPatience_s, 0};
    setsockopt(fd, SOL_SOCKET, SO_RCVTIMEO, &patience, sizeof patience);
    setsockopt(fd, SOL_SOCKET, SO_SNDTIMEO, &patience, sizeof patience);
    if (connect(fd, at->ai_addr, at->ai_addrlen) == 0) {
      connected = fd;
    } else {
      close(fd);
    }
  }
  freeaddrinfo(found);
  return connected;
}

// State of one handshake.
struct Handshake {
  bool done = false;
  bool other_side_speaks_tls = false;
  long verify_error = X509_V_OK;
  std::string alert;  // By which the other side refused.
  CertificateFacts theirs;
};

void KeepAlert(Handshake& handshake) {
  for (unsigned long code; (code = ERR_get_error()) != 0;) {
    if (ERR_GET_LIB(code) != ERR_LIB_SSL) continue;
    const int reason = ERR_GET_REASON(code);
    // Alerts that came in have reasons from here on.   Source: OpenSSL's sslerr.h.
    if (reason >= SSL_AD_REASON_OFFSET && handshake.alert.empty()) {
      const char* text = ERR_reason_error_string(code);
      handshake.alert = text == nullptr ? "an alert" : text;
    }
  }
}

Handshake Try(int fd, const RpcAddress& address, const TlsIdentity* own) {
  Handshake result;
  ERR_clear_error();
  const std::unique_ptr<SSL_CTX, FreeWith<SSL_CTX_free>> context(SSL_CTX_new(TLS_client_method()));
  if (context == nullptr) return result;
  const auto load = [](const std::string& pem) {
    return std::unique_ptr<BIO, FreeWith<BIO_free_all>>(
        BIO_new_mem_buf(pem.data(), static_cast<int>(pem.size())));
  };
  if (own != nullptr) {
    const auto ca_bio = load(own->ca_pem);
    const auto crt_bio = load(own->own.certificate_pem);
    const auto key_bio = load(own->own.key_pem);
    X509* const ca = PEM_read_bio_X509(ca_bio.get(), nullptr, nullptr, nullptr);
    X509* const crt = PEM_read_bio_X509(crt_bio.get(), nullptr, nullptr, nullptr);
    EVP_PKEY* const key = PEM_read_bio_PrivateKey(key_bio.get(), nullptr, nullptr, nullptr);
    X509_STORE_add_cert(SSL_CTX_get_cert_store(context.get()), ca);
    SSL_CTX_use_certificate(context.get(), crt);
    SSL_CTX_use_PrivateKey(context.get(), key);
    X509_free(ca);
    X509_free(crt);
    EVP_PKEY_free(key);
  }
  const std::unique_ptr<SSL, FreeWith<SSL_free>> ssl(SSL_new(context.get()));
  if (ssl == nullptr) return result;
  constexpr unsigned char kHttp2[] = {2, 'h', '2'};
  SSL_set_alpn_protos(ssl.get(), kHttp2, sizeof kHttp2);
  X509_VERIFY_PARAM* const wanted = SSL_get0_param(ssl.get());
  if (X509_VERIFY_PARAM_set1_ip_asc(wanted, address.host.c_str()) != 1) {
    ERR_clear_error();
    SSL_set1_host(ssl.get(), address.host.c_str());
    SSL_set_tlsext_host_name(ssl.get(), address.host.c_str());
  }
  // Verified, but gone on with: then the other side's opinion shows too.
  SSL_set_verify(ssl.get(), SSL_VERIFY_NONE, nullptr);
  SSL_set_fd(ssl.get(), fd);
  result.done = SSL_connect(ssl.get()) == 1;
  if (!result.done) KeepAlert(result);
  X509* const theirs = SSL_get0_peer_certificate(ssl.get());
  result.other_side_speaks_tls = result.done || theirs != nullptr || !result.alert.empty();
  if (theirs != nullptr) {
    result.verify_error = SSL_get_verify_result(ssl.get());
    const std::unique_ptr<BIO, FreeWith<BIO_free_all>> bio(BIO_new(BIO_s_mem()));
    char* data = nullptr;
    PEM_write_bio_X509(bio.get(), theirs);
    const long size = BIO_get_mem_data(bio.get(), &data);
    const auto facts = ReadCertificate(std::string(data, static_cast<size_t>(size)));
    if (facts.ok()) result.theirs = *facts;
  }
  // With TLS 1.3 the other side judges our certificate after our handshake has ended; gRPC then
  // just hangs up, where it would else begin HTTP/2 with a first frame of its own.
  char byte;
  if (const int got = result.done ? SSL_read(ssl.get(), &byte, 1) : 1; got <= 0) {
    const bool timed_out = SSL_get_error(ssl.get(), got) == SSL_ERROR_WANT_READ;
    KeepAlert(result);
    if (result.alert.empty() && !timed_out) result.alert = "it hangs up";
  }
  ERR_clear_error();
  return result;
}

std::string Join(const std::vector<std::string>& texts) {
  std::string joined;
  for (const std::string& text : texts) joined += (joined.empty() ? "" : ", ") + text;
  return joined;
}

absl::Status ExplainTheirs(const Handshake& handshake, const std::string& who,
                           const RpcAddress& address, const TlsIdentity& own) {
  switch (handshake.verify_error) {
    case X509_V_OK:
      return absl::OkStatus();
    case X509_V_ERR_CERT_HAS_EXPIRED:
      return Unauthenticated(
          "{} shows a certificate that expired on {}; its operator makes a new one with "
          "`coordinator init DIR --renew server` and starts it again",
          who, DateOf(handshake.theirs.not_after_unix_s));
    case X509_V_ERR_CERT_NOT_YET_VALID:
      return Unauthenticated(
          "{} shows a certificate that is not valid before {}; is this machine's clock right?", who,
          DateOf(handshake.theirs.not_before_unix_s));
    case X509_V_ERR_HOSTNAME_MISMATCH:
    case X509_V_ERR_IP_ADDRESS_MISMATCH:
      return Unauthenticated(
          "{} shows a certificate for {} and not for {}; connect by one of these names, or have "
          "its certificate made anew with `coordinator init DIR --renew server --host {}`",
          who, Join(handshake.theirs.hosts), address.host, address.host);
    default:
      return Unauthenticated(
          "{} shows a certificate that the authority in {}/ca.crt did not sign; is this another "
          "farm, or has it a new authority? Get {}",
          who, own.dir, kHowToIssue);
  }
}

}  // namespace

absl::Status ExplainRpcSecurity(const RpcAddress& address, const RpcSecurity& security) {
  if (address.is_unix()) return absl::OkStatus();
  const int fd = Connect(address);
  if (fd < 0) return absl::OkStatus();
  const Handshake handshake = Try(fd, address, security.tls.get());
  close(fd);
  const std::string who = "what answers at " + address.ToString();
  if (security.tls == nullptr) {
    if (!handshake.other_side_speaks_tls) return absl::OkStatus();
    return Unauthenticated("{} speaks TLS; give --tls DIR (or $PARALLAX_TLS) with {}", who,
                           kHowToIssue);
  }
  if (!handshake.other_side_speaks_tls) {
    return Unauthenticated(
        "{} does not speak TLS; a coordinator does with `coordinator serve --tls DIR/server`, and "
        "without it --tls has to be left away here too",
        who);
  }
  RETURN_IF_ERROR(ExplainTheirs(handshake, who, address, *security.tls));
  if (handshake.alert.empty()) return absl::OkStatus();
  return Unauthenticated("{} refuses the certificate in {} ({}); get {}", who, security.tls->dir,
                         handshake.alert, kHowToIssue);
}

}  // namespace parallax
