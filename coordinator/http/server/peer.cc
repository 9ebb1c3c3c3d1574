#include "coordinator/http/server/peer.h"

#include <openssl/pem.h>
#include <openssl/ssl.h>
#include <openssl/x509v3.h>

#include <memory>

#include "common/rpc/certificate.h"

namespace parallax {
namespace {

constexpr unsigned char kSessionContext[] = "parallax";

std::string PemOf(X509* certificate) {
  const std::unique_ptr<BIO, decltype(&BIO_free_all)> bio(BIO_new(BIO_s_mem()), &BIO_free_all);
  if (bio == nullptr || PEM_write_bio_X509(bio.get(), certificate) != 1) return "";
  char* data = nullptr;
  const long size = BIO_get_mem_data(bio.get(), &data);
  return std::string(data, static_cast<size_t>(size));
}

}  // namespace

bool SetUpTls(const std::string& dir, ssl_ctx_st& context) {
  const std::string ca = dir + "/ca.crt", certificate = dir + "/tls.crt", key = dir + "/tls.key";
  if (SSL_CTX_set_min_proto_version(&context, TLS1_2_VERSION) != 1 ||
      SSL_CTX_use_certificate_chain_file(&context, certificate.c_str()) != 1 ||
      SSL_CTX_use_PrivateKey_file(&context, key.c_str(), SSL_FILETYPE_PEM) != 1 ||
      SSL_CTX_check_private_key(&context) != 1 ||
      SSL_CTX_load_verify_locations(&context, ca.c_str(), nullptr) != 1) {
    return false;
  }
  SSL_CTX_set_client_CA_list(&context, SSL_load_client_CA_file(ca.c_str()));
  SSL_CTX_set_session_id_context(&context, kSessionContext, sizeof kSessionContext - 1);
  SSL_CTX_set_verify(&context, SSL_VERIFY_PEER, nullptr);
  return true;
}

std::optional<RpcCaller> CallerOf(const ssl_st* connection) {
  if (connection == nullptr || SSL_get_verify_result(connection) != X509_V_OK) return std::nullopt;
  const std::unique_ptr<X509, decltype(&X509_free)> certificate(
      SSL_get1_peer_certificate(connection), &X509_free);
  if (certificate == nullptr) return std::nullopt;
  RpcCaller caller{.has_certificate = true};
  const auto facts = ReadCertificate(PemOf(certificate.get()));
  if (!facts.ok()) return caller;
  caller.name = facts->name;
  caller.sha256 = facts->sha256;
  caller.role = facts->role;
  return caller;
}

bool IsNameOf(const std::string& certificate_pem, const std::string& host) {
  const std::unique_ptr<BIO, decltype(&BIO_free_all)> bio(
      BIO_new_mem_buf(certificate_pem.data(), static_cast<int>(certificate_pem.size())),
      &BIO_free_all);
  const std::unique_ptr<X509, decltype(&X509_free)> certificate(
      bio == nullptr ? nullptr : PEM_read_bio_X509(bio.get(), nullptr, nullptr, nullptr),
      &X509_free);
  return certificate != nullptr &&
         X509_check_host(certificate.get(), host.data(), host.size(), 0, nullptr) == 1;
}

}  // namespace parallax
